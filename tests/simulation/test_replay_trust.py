"""A log of others runs nothing of theirs unless it is trusted."""

import contextlib
import copy
import importlib

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import BuildError, CrazychoirError
from crazychoir_fw.simulation import DroneConfig, World, replay
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.replay import ReplayError


@pytest.fixture
def log():
    world = World([DroneConfig("cf1")])
    recorder = FlightRecorder(world)
    for _ in range(3):
        world.run(0.01)
        recorder.sample()
    return recorder.finish()


def naming(log, **config):
    """Return the log with a drone that was configured in another way."""
    spoilt = copy.deepcopy(log)
    spoilt.journal.recipe["drones"] = [{"id": "cf1", **config}]
    return spoilt


@pytest.mark.parametrize("app_named", ["evil.c", ["evil.c"]])
def test_an_app_of_a_log_is_compiled_only_with_trust(log, tmp_path, app_named):
    evil = tmp_path / "evil.c"
    evil.write_text("this is no C")
    spoilt = naming(log, app=str(evil) if isinstance(app_named, str) else [str(evil)])
    with pytest.raises(ReplayError, match=r"names C that a replay compiles and runs, .*evil\.c: read what they do"):
        replay(spoilt)
    spoilt.save(tmp_path / "log.npz")
    refused = CliRunner().invoke(app, ["replay", str(tmp_path / "log.npz"), "--check"])
    assert refused.exit_code == 2
    assert "evil.c: read what they do, then add --trust" in refused.stderr
    with pytest.raises(BuildError, match="this is no C"):  # the compiler quotes it
        replay(spoilt, trust=True)


def test_a_terminal_is_asked(log, tmp_path, monkeypatch):
    evil = tmp_path / "evil.c"
    evil.write_text("this is no C")
    naming(log, app=[str(evil)]).save(tmp_path / "log.npz")
    monkeypatch.setattr(importlib.import_module("crazychoir_fw.cli.replay"), "_is_terminal", lambda: True)
    declined = CliRunner().invoke(app, ["replay", str(tmp_path / "log.npz"), "--check"], input="n\n")
    assert declined.exit_code == 2
    assert "evil.c. Run them?" in declined.stderr
    assert "no C" not in declined.stderr
    agreed = CliRunner().invoke(app, ["replay", str(tmp_path / "log.npz"), "--check"], input="y\n")
    assert agreed.exit_code == 2
    assert "this is no C" in agreed.stderr  # what the compiler says


def test_a_motor_control_of_a_log_is_never_run(log, tmp_path):
    marker, evil = tmp_path / "marker", tmp_path / "evil.py"
    evil.write_text(f"open({str(marker)!r}, 'w').close()\n")
    named = f"{evil}:Evil"
    for config in ({"motor_ctrl": named}, {"attributes": {"motor_ctrl": named}}):
        with contextlib.suppress(CrazychoirError):
            replay(naming(log, **config))
        assert not marker.exists()


def test_a_motor_control_of_the_scene_is_never_run_by_a_replay(log, tmp_path):
    marker, evil, scene = tmp_path / "marker", tmp_path / "evil.py", tmp_path / "scene.xml"
    evil.write_text(f"open({str(marker)!r}, 'w').close()\n")
    scene.write_text(
        '<mujoco><extension><plugin plugin="crazychoir.crazyflie"/></extension><worldbody>'
        '<body name="cf9" pos="3 3 0.1"><freejoint/><geom size="0.03" mass="0.03"/>'
        '<plugin plugin="crazychoir.crazyflie">'
        f'<config key="motor_ctrl" value="{evil}:Evil"/></plugin></body></worldbody></mujoco>'
    )
    spoilt = naming(log)
    spoilt.journal.recipe["scene"] = str(scene)
    with contextlib.suppress(CrazychoirError):
        replay(spoilt)
    assert not marker.exists()
    with pytest.raises(CrazychoirError):
        World.from_mjcf(scene)  # which a user asks for
    assert marker.exists()
