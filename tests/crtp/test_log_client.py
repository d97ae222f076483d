"""The real client's log service against ours (docs/reference/crtp-cflib.md#4, #8 and #19)."""

import numpy as np
import pytest
from cflib.crazyflie.log import LogConfig
from cflib.crazyflie.toccache import TocCache
from cflib_client import Client

from crazychoir_fw.crtp.station import Station
from crazychoir_fw.onboard.variables import log_table
from crazychoir_fw.simulation import DroneConfig, World


class LogClient(Client):
    def __init__(self, station, cache) -> None:
        super().__init__(station)
        self.platform, self.log = self.cf.platform, self.cf.log
        self.is_ready = False
        self.platform.fetch_platform_informations(lambda: self.log.refresh_toc(self._ready, TocCache(rw_cache=cache)))
        self.pump()

    def _ready(self) -> None:
        self.is_ready = True

    def log_for(self, config, seconds):
        """Add a log configuration, run it and return what it received: (time stamp, values)."""
        told, errors = [], []
        config.data_received_cb.add_callback(lambda stamp, values, _: told.append((stamp, values)))
        config.error_cb.add_callback(lambda _, message: errors.append(message))
        self.log.add_config(config)
        config.start()
        self.pump()
        for _ in range(round(seconds * 100)):
            self.station.context.world.step(10)
            self.pump()
        assert errors == []
        return told


@pytest.fixture(scope="module")
def world():
    return World([DroneConfig("cf1")], visuals=False)


@pytest.fixture
def client(world, tmp_path):
    client = LogClient(Station(world, world["cf1"]), str(tmp_path))
    yield client
    client.station.end_session()
    world.step(20)


def config(name, period, **variables):
    made = LogConfig(name, period)
    for variable, kind in variables.items():
        made.add_variable(variable, kind)
    return made


def test_the_table_arrives(client):
    assert client.is_ready
    assert client.platform.get_protocol_version() == 12
    known = {
        f"{group}.{name}": (element.ident, element.pytype)
        for group, names in client.log.toc.toc.items()
        for name, element in names.items()
    }
    formats = {"u1": "<B", "u2": "<H", "u4": "<L", "i1": "<b", "i2": "<h", "i4": "<i", "f4": "<f"}
    assert known == {
        name: (index, formats[row.dtype.str[1:]]) for index, (name, row) in enumerate(log_table(0).items())
    }


def test_the_second_time_it_comes_from_the_cache(client, world, tmp_path):
    again = LogClient(Station(world, world["cf1"]), str(tmp_path))
    assert again.is_ready
    assert len(again.link.sent) == 4
    assert again.log.toc.toc.keys() == client.log.toc.toc.keys()


def test_a_block_of_types_from_the_table(client, world):
    names = ("stateEstimate.z", "supervisor.info", "pm.vbat", "pm.state", "range.zrange")
    told = client.log_for(config("mixed", 10, **dict.fromkeys(names)), 1.0)
    stamps = [stamp for stamp, _ in told]
    assert len(told) in (99, 100)
    assert np.all(np.diff(stamps) == 10)
    assert stamps[-1] == world["cf1"].struct.onboard.tick
    assert told[-1][1] == {name: pytest.approx(world["cf1"].log[name]) for name in names}


def test_the_block_of_cfclient(client):
    kinds = {"stabilizer.thrust": "uint16_t", "sys.canfly": None, "supervisor.info": None}
    motors = {f"motor.m{i}": None for i in (1, 2, 3, 4)}
    assert client.log_for(config("flight tab", 100, **kinds, **motors), 0.5)
    assert client.log_for(config("battery", 1000, **{"pm.vbat": "float", "pm.state": "int8_t"}), 2.0)


def test_twelve_halves_need_an_append(client, world):
    names = [f"stateEstimate.{axis}" for axis in ("x", "y", "z")]
    names += [f"stabilizer.{axis}" for axis in ("yaw", "roll", "pitch")]
    names += [f"kalman.stateP{axis}" for axis in "XYZ"] + ["gyro.z", "gyro.x", "gyro.y"]
    client.link.sent.clear()
    told = client.log_for(config("odom", 10, **dict.fromkeys(names, "FP16")), 0.1)
    sizes = [(1 + len(data), data[0]) for _, _, data in client.link.sent]
    assert sizes == [(31, 6), (3 + 3 * 3, 7), (4, 3)]
    values = told[-1][1]
    for name in names:
        assert values[name] == pytest.approx(world["cf1"].log[name], abs=1e-4, rel=1e-3)


def test_stop_and_delete(client, world):
    some = config("some", 10, **{"pm.vbat": None})
    told = client.log_for(some, 0.1)
    assert some.started
    some.stop()
    client.pump()
    assert not some.started
    count = len(told)
    world.step(50)
    client.pump()
    assert len(told) == count
    some.delete()
    client.pump()
    assert not some.added
