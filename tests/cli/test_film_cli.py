"""`crazychoir film`: a film of a recorded flight from its log alone."""

import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.opengl import rendering_available

WITHOUT_OPENGL = rendering_available()


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


@pytest.fixture
def folder(tmp_path):
    """A log of one drone that climbs for 2 s."""
    time = np.linspace(0.0, 2.0, 21)
    signals = {f"stateEstimate.{axis}": np.zeros((21, 1)) for axis in "xyz"}
    signals["stateEstimate.z"] = time[:, None]
    FlightLog(time, ["cf1"], signals, {"mission": "climb", "windows": [["takeoff", 0.0, 2.0]]}).save(
        tmp_path / "log.npz"
    )
    return tmp_path


@pytest.mark.skipif(WITHOUT_OPENGL is not None, reason=str(WITHOUT_OPENGL))
def test_a_film_is_made_of_a_log_at_any_speed_and_of_any_part(folder):
    import imageio.v3 as iio

    small = ["--size", "96x64", "--fps", "5"]
    assert run("film", folder, *small).exit_code == 0
    assert iio.imread(folder / "flight.mp4").shape == (11, 64, 96, 3)
    result = run("film", folder / "log.npz", *small, "--speed", "0.5", "--from", "1", "--camera", "chase:cf1", "--bare")
    assert result.exit_code == 0 and "Written to" in result.output
    assert len(iio.imread(folder / "flight.mp4")) == 11
    assert run("film", folder, *small, "--gif").exit_code == 0
    assert (folder / "flight.gif").read_bytes()[:6] == b"GIF89a"


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--camera", "fpv:cf2"], "no drone 'cf2' for the camera; there are cf1"),
        (["--size", "huge"], "--size is huge, allowed: 64x64 to 3840x2160"),
        (["--from", "3"], "there is no sample, allowed: a part of 0 to 2 s"),
        (["--out", "film.avi"], "allowed: a name that ends with .mp4, .gif, .webp"),
    ],
)
def test_a_film_that_cannot_be_made_gets_one_sentence(folder, options, message):
    result = run("film", folder, *options)
    assert result.exit_code == 2
    assert message in " ".join(result.output.split())
    assert [path.name for path in folder.iterdir()] == ["log.npz"]


def test_without_opengl_there_is_one_sentence(folder, monkeypatch):
    from crazychoir_fw.recording import opengl

    opengl._context_class.cache_clear()
    monkeypatch.setenv("MUJOCO_GL", "off")
    try:
        result = run("film", folder)
    finally:
        opengl._context_class.cache_clear()
    assert result.exit_code == 2
    assert "no film: no rendering: MUJOCO_GL=off" in " ".join(result.output.split())


def test_a_folder_without_a_log_is_refused(tmp_path):
    result = run("film", tmp_path)
    assert result.exit_code == 2 and "cannot be read" in " ".join(result.output.split())
