"""Drones over the radio, of a served world whose time goes on only when the layers ask for it."""

import threading
import time

import numpy as np

from crazychoir_fw.experiment.hardware_backend import HardwareBackend
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.simulation import DroneConfig, World


class Served(HardwareBackend):
    """A backend in lockstep with a world of this process."""

    def __init__(self, mission, tmp_path, kind="fpqr", ids=None):
        ids = [drone.id for drone in mission.fleet] if ids is None else ids
        fleet = [DroneConfig(**drone_settings(drone)) for drone in mission.fleet if drone.id in ids]
        self.world_there = World(fleet, seed=mission.seed + 1, visuals=False)
        # pings of cflib go by the wall, sessions in lockstep by simulated time, which is much faster here
        self.server = self.world_there.serve(port=0, silence=1000.0)
        self.server.start()
        uris = dict(zip(ids, self.server.uris.values(), strict=True))
        super().__init__(
            uris,
            kind,
            sleep=self.let_go_on,
            connects=False,
            clock=lambda: self.world_there.time,
            threaded=False,
            cache=tmp_path / "tables",
        )
        with self.going_on():
            self.handler.connect()
            while np.isnan(self.poses().position).any():
                time.sleep(0.001)
        self._start = self.world_there.time
        self.pace.begin_anew()

    def let_go_on(self, seconds):
        self.handler.tick()
        self.world_there.run(seconds)
        end = time.monotonic() + 0.02
        for drone in self.handler:
            while drone.odometry.time_s < self.world_there.time - 0.03 and time.monotonic() < end:
                time.sleep(0.0002)

    def unlock(self, indices):
        with self.going_on():
            return super().unlock(indices)

    def close(self):
        with self.going_on():
            super().close()
        self.server.close()

    def going_on(self):
        return _GoingOn(self)


class _GoingOn:
    """Time goes on in another thread, for calls that wait for the drone."""

    def __init__(self, served):
        self.served = served

    def __enter__(self):
        self.ends = threading.Event()
        self.thread = threading.Thread(target=self.run)
        self.thread.start()

    def run(self):
        while not self.ends.is_set():
            self.served.world_there.run(0.01)
            time.sleep(0.002)

    def __exit__(self, *_):
        self.ends.set()
        self.thread.join()
