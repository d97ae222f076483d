"""What needs a library that is not installed says so in one sentence, before anything flies."""

import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLES = Path(__file__).parents[2] / "examples"
DRONES = "--backend hardware --uri-base udp://127.0.0.1:1"


@pytest.mark.parametrize(
    ("library", "extra", "words"),
    [
        ("cflib", "radio", f"fly bearing_formation.yaml {DRONES}"),
        ("cflib", "radio", "fly aggregative_moving_intruders_mixed.yaml"),
        ("cflib", "radio", f"gui draw.yaml --no-browser --port 0 {DRONES}"),
        ("quadprog", "optimization", "fly mpc.yaml"),
        ("quadprog", "optimization", "fly mpc.yaml --backend integrator"),
        ("nicegui", "gui", "gui draw.yaml --no-browser --port 0"),
        ("mcap", "mcap", "fly hello_swarm.yaml --mcap"),
        ("rclpy", "ros", "fly bearing_formation.yaml --ros"),
        ("rclpy", "ros", "ros land"),
    ],
)
def test_one_sentence_says_what_to_install(library, extra, words, tmp_path):
    if library != "nicegui" and words.startswith("gui"):
        pytest.importorskip("nicegui")
    words = [str(EXAMPLES / word) if word.endswith(".yaml") else word for word in words.split()]
    if words[0] == "fly":
        words += ["--no-video", "--out", str(tmp_path)]
    program = f"import sys; sys.modules[{library!r}] = None; from crazychoir_fw.cli import app; app()"
    ran = subprocess.run([sys.executable, "-c", program, *words], capture_output=True, text=True, timeout=120)
    assert ran.returncode == 2, ran.stderr
    assert f"run pip install 'crazychoir-fw[{extra}]'" in ran.stderr.splitlines()[-1]
    assert "Traceback" not in ran.stdout + ran.stderr
    assert not any(tmp_path.iterdir())
