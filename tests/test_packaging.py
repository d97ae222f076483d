"""What is installed is complete, and says the same everywhere."""

import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from fnmatch import fnmatch
from pathlib import Path

import pytest
import yaml

from crazychoir_fw.cli.new import KINDS
from crazychoir_fw.common import shared_folders
from crazychoir_fw.common.shared_folders import SHARED, shared_folder
from crazychoir_fw.common.version import __version__
from crazychoir_fw.mujoco_models import SCENES, VEHICLES

if sys.version_info >= (3, 11):
    import tomllib
else:
    tomllib = pytest.importorskip("tomli")

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture(scope="module")
def setuptools():
    return tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]


def test_every_file_of_the_package_is_in_the_wheel(setuptools):
    listed = subprocess.run(["git", "ls-files", "-z", "crazychoir_fw"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout")
    data = setuptools["package-data"]
    missing = []
    for name in filter(None, listed.stdout.split("\0")):
        path = Path(name)
        if path.suffix == ".py":
            continue
        holders = {folder: path.relative_to(folder) for folder in path.parents if str(folder) != "."}
        if not any(
            fnmatch(str(rest), pattern)
            for folder, rest in holders.items()
            for pattern in data.get(str(folder).replace("/", "."), [])
        ):
            missing.append(name)
    assert missing == []


def test_no_symbolic_link_is_tracked():
    # checkouts on Windows and unpacked archives hold a text file in its place
    listed = subprocess.run(["git", "ls-files", "--stage"], cwd=ROOT, capture_output=True, text=True)
    if listed.returncode:
        pytest.skip("not a git checkout")
    assert [line for line in listed.stdout.splitlines() if line.startswith("120000")] == []


def test_a_built_package_holds_the_folders_of_the_repository(tmp_path):
    build = [sys.executable, "setup.py", "-q", "egg_info", "-e", tmp_path, "build_py", "--build-lib", tmp_path]
    subprocess.run(build, cwd=ROOT, check=True, stderr=subprocess.DEVNULL)
    installed = tmp_path / "crazychoir_fw" / SHARED
    sources = (installed / "bindings/sources.txt").read_text().split()
    templates = [file for kind in KINDS.values() for file in kind.files]
    models = [f"mujoco_models/{file}" for file in (*VEHICLES.values(), *SCENES.values())]
    assert [file for file in (*sources, *templates, *models) if not (installed / file).is_file()] == []
    meshes = re.findall(r'file="(\S+\.(?:obj|png))"', "".join((installed / file).read_text() for file in models))
    assert meshes
    for mesh in meshes:
        assert list((installed / "mujoco_models").rglob(mesh)), mesh


def test_an_installed_package_reads_its_own_copy(tmp_path, monkeypatch):
    assert shared_folder("bindings") == ROOT / "bindings"
    monkeypatch.setattr(shared_folders, "_PACKAGE", tmp_path)
    (tmp_path / SHARED).mkdir()
    assert shared_folder("bindings") == tmp_path / SHARED / "bindings"


def test_ros_finds_marker_manifest_and_launch_files(setuptools):
    files = setuptools["data-files"]
    for patterns in files.values():
        for pattern in patterns:
            assert list(ROOT.glob(pattern)), pattern
    assert files["share/ament_index/resource_index/packages"] == ["resource/crazychoir_fw"]
    assert ET.parse(ROOT / "package.xml").findtext("name") == "crazychoir_fw"


def test_the_citation_has_the_version_of_this_package():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["version"] == __version__
    assert citation["cff-version"] == "1.2.0"
    assert {"title", "authors", "message", "license"} <= citation.keys()


def test_workflows_call_sections_that_exist():
    sections = re.search(r"must be one of (.*)\" >&2", (ROOT / ".ci/run").read_text())[1].split(", ")
    for file in (ROOT / ".github/workflows").glob("*.yml"):
        jobs = yaml.safe_load(file.read_text())["jobs"].values()
        words = [step.get("run", "") for job in jobs for step in job["steps"]]
        for called in re.findall(r"\.ci/run ([a-z ]+)", "\n".join(words)):
            assert set(called.split()) <= set(sections), file
