"""Signals that are computed when they are asked for are those that are computed at once."""

import hashlib

import numpy as np
import pytest

from crazychoir_fw.recording.signals import LazySignals, signals_of
from crazychoir_fw.simulation import DroneConfig, World
from crazychoir_fw.simulation.recorder import FlightRecorder


def flown() -> FlightRecorder:
    world = World([DroneConfig("cf1"), DroneConfig("cf2", (1.0, 0.0))])
    recorder = FlightRecorder(world)
    recorder.run(0.3)
    return recorder


@pytest.fixture
def recorder():
    return flown()


def digest(signals: LazySignals) -> str:
    whole = hashlib.sha256()
    for samples in signals.raw():
        whole.update(samples.tobytes())
    return whole.hexdigest()


def test_all_of_them_are_those_that_are_computed_at_once(recorder):
    lazy, whole = recorder.finish().signals, signals_of(recorder._layout(), recorder._column)
    assert isinstance(lazy, LazySignals)
    assert list(lazy) == list(whole) and len(lazy) == len(whole)
    # backwards, so that those that are read one by one are others
    for name in reversed(list(lazy)):
        assert lazy[name].dtype == whole[name].dtype
        np.testing.assert_array_equal(lazy[name], whole[name])


def test_they_are_a_mapping_that_can_be_changed(recorder):
    signals = recorder.finish().signals
    signals["layers.x"] = np.zeros((30, 2))
    del signals["pm.vbat"]
    assert "layers.x" in signals and "pm.vbat" not in signals and "nothing" not in signals
    assert list(signals)[-1] == "layers.x"
    with pytest.raises(KeyError):
        signals["nothing"]


def test_the_bits_of_two_equal_flights_are_equal_though_their_memory_lies_elsewhere():
    first, second = flown(), flown()
    addresses = [drone.memory.ctypes.data for one in (first, second) for drone in one._world.drones]
    assert len(set(addresses)) == 4
    assert digest(first.finish().signals) == digest(second.finish().signals)


def test_one_bit_of_one_signal_changes_the_bits(recorder):
    before = digest(recorder.finish().signals)
    signals = recorder.finish().signals
    place, kind = signals._layout["parts"][0]["places"]["stateEstimate.z"]
    signals._columns["part0"][3, 1, place : place + np.dtype(kind).itemsize] ^= 1
    assert digest(signals) != before


def test_a_long_record_has_no_samples_beside_its_signals(recorder, monkeypatch):
    monkeypatch.setattr("crazychoir_fw.simulation.recorder._SPILL_BYTES", 10_000)
    assert type(recorder.finish().signals) is dict
