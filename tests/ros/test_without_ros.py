"""Only crazychoir_fw/ros needs ROS."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import crazychoir_fw

PACKAGE = Path(crazychoir_fw.__file__).parent
OF_ROS = {"rclpy", "rcl_interfaces", "builtin_interfaces"}


def imported(path):
    text = path.read_text()
    # most files need not be parsed
    tree = ast.parse(text) if any(word in text for word in (*OF_ROS, "_msgs", "_srvs")) else ast.Module()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            yield node.module


def test_only_the_ros_layer_imports_modules_of_ros():
    found = {
        f"{path.relative_to(PACKAGE)}: {name}"
        for path in PACKAGE.rglob("*.py")
        if path.relative_to(PACKAGE).parts[0] != "ros"
        for name in imported(path)
        if name.split(".")[0] in OF_ROS or name.split(".")[0].endswith("_msgs") or name.split(".")[0].endswith("_srvs")
    }
    assert found == set()


BLOCKED = """
import sys
from importlib.abc import MetaPathFinder

class NoRos(MetaPathFinder):
    def find_spec(self, name, path, target=None):
        root = name.split(".")[0]
        if root in ("rclpy", "rcl_interfaces", "builtin_interfaces") or root.endswith(("_msgs", "_srvs")):
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, NoRos())
"""


def run(program):
    return subprocess.run([sys.executable, "-c", BLOCKED + program], capture_output=True, text=True, timeout=120)


def test_the_layers_work_without_it():
    layers = "cli, common, control, flight, guidance, mission, mocap, planning, radio, simulation"
    ran = run(f"from crazychoir_fw import {layers}; print(sorted(m for m in sys.modules if m.startswith('rclpy')))")
    assert (ran.returncode, ran.stdout.strip()) == (0, "[]"), ran.stderr


def test_the_ros_layer_says_how_to_get_it():
    ran = run("import crazychoir_fw.ros")
    assert ran.returncode != 0
    assert "pip install 'crazychoir-fw[ros]'" in ran.stderr


@pytest.mark.parametrize("option", ["--ros", "--ros-join"])
def test_the_page_says_how_to_get_it(option):
    pytest.importorskip("nicegui")
    mission = Path(__file__).parents[2] / "examples" / "draw.yaml"
    ran = run(
        f"from crazychoir_fw.cli import app; app(['gui', {str(mission)!r}, {option!r}, '--no-browser', '--port', '0'])"
    )
    assert ran.returncode == 2, ran.stderr
    assert ran.stderr.startswith("--ros: crazychoir_fw.ros needs rclpy, which is not installed")
    assert "Traceback" not in ran.stderr
