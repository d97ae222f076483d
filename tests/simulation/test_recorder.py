import errno
import os

import numpy as np
import pytest
from worlds import make_world

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.recording.signals import roll_pitch_yaw_deg
from crazychoir_fw.simulation import FlightRecorder, recorder
from crazychoir_fw.simulation.swarm_views import swarm_views


@pytest.mark.parametrize("count", [1, 3])
def test_views_of_the_swarm_are_the_logs_of_its_drones(count):
    world = make_world(count)
    views = swarm_views(world)
    world.wait_until_ready()
    world.run(0.3)
    for name, view in views.items():
        for value, drone in zip(view, world.drones, strict=True):
            assert value == pytest.approx(drone.log[name], nan_ok=True)


def test_log_holds_every_signal_of_every_drone():
    world = make_world(2)
    recorder = FlightRecorder(world)
    recorder.run(0.5)
    log = recorder.finish({"mission": "test"})
    assert log.time == pytest.approx(np.arange(1, 51) / 100)
    assert log.drone_ids == ["cf1", "cf2"]
    assert all(signal.shape == (50, 2) for signal in log.signals.values())
    assert log.signals["sim.x"][-1] == pytest.approx([0.0, 0.5], abs=1e-3)
    assert set(world.drones[0].log) <= set(log.signals)
    assert recorder.qpos.shape == (50, world.model.nq)


def test_log_says_what_flew_and_how_it_was_built():
    world = make_world(2, seed=9)
    recorder = FlightRecorder(world)
    recorder.run(0.1)
    metadata = recorder.finish({"mission": "test"}).metadata
    assert metadata["mission"] == "test"
    assert metadata["seed"] == 9
    assert metadata["drones"]["cf2"] == {"provider": "builtin", "platform": "cf2"}
    assert [provider["provider"] for provider in metadata["providers"]] == ["builtin"]
    assert "-ffp-contract=off" in metadata["flags"]
    assert metadata["version"] and metadata["compiler"] and metadata["mujoco"]


def test_rate_must_divide_a_thousand():
    with pytest.raises(RangeError, match="rate_hz is 300"):
        FlightRecorder(make_world(), rate_hz=300)


def test_attitude_has_the_sign_of_the_firmware():
    """Nose up is positive pitch, although it is a negative rotation about y."""
    half = np.radians(10.0) / 2
    nose_up = np.array([np.cos(half), 0.0, -np.sin(half), 0.0])
    assert roll_pitch_yaw_deg(nose_up) == pytest.approx([0.0, 10.0, 0.0])


@pytest.mark.parametrize("count", [1, 3])
def test_compressed_signals_are_as_new_as_the_others(count):
    world = make_world(count)
    world.wait_until_ready()
    for drone in world.drones:
        drone.high_level_commander.takeoff(0.5, 1.0)
    recorder = FlightRecorder(world)
    recorder.run(1.5)
    log = recorder.finish()
    for group in ("stateEstimate", "ctrltarget"):
        for name in ("x", "z", "vz"):
            short, full = log.signals[f"{group}Z.{name}"], log.signals[f"{group}.{name}"]
            np.testing.assert_array_equal(short, np.trunc(full * np.float32(1000.0)))
        assert np.all(log.signals[f"{group}Z.z"][-1] > 450)


def signals_of_a_flight():
    world = make_world(3, seed=4)
    flown = FlightRecorder(world)
    flown.run(0.8)
    return flown, flown.finish().signals


def assert_equal_signals(one, other):
    assert one.keys() == other.keys()
    for name, signal in one.items():
        assert signal.tobytes() == other[name].tobytes(), name


def test_a_long_flight_moves_out_of_memory_and_comes_back_bit_by_bit(monkeypatch):
    _, kept = signals_of_a_flight()
    monkeypatch.setattr(recorder, "_SPILL_BYTES", 50_000)
    flown, spilled = signals_of_a_flight()
    assert flown._samples.bytes_in_memory <= 50_000
    assert_equal_signals(kept, spilled)


def test_a_disk_without_room_leaves_a_long_flight_in_memory(monkeypatch):
    _, kept = signals_of_a_flight()

    def refuse(*_):
        raise OSError(errno.ENOSPC, "no space left on device")

    monkeypatch.setattr(recorder, "_SPILL_BYTES", 50_000)
    monkeypatch.setattr(os, "pwrite", refuse)
    flown, signals = signals_of_a_flight()
    assert flown._samples.bytes_in_memory > 300_000
    assert_equal_signals(kept, signals)
