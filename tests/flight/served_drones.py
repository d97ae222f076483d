"""Drones over the radio, of a served world whose time goes on only when the layers ask for it."""

import time
from contextlib import contextmanager

import numpy as np
from lockstep import SILENCE_S, GoingOn, wait_for_odometry

from crazychoir_fw.flight.hardware_backend import HardwareBackend
from crazychoir_fw.mission.fleet import drone_settings
from crazychoir_fw.simulation import DroneConfig, World


class Served(HardwareBackend):
    """A backend in lockstep with a world of this process."""

    goes_on = False

    def __init__(self, mission, tmp_path, kind="fpqr", ids=None):
        ids = [drone.id for drone in mission.fleet] if ids is None else ids
        fleet = [DroneConfig(**drone_settings(drone)) for drone in mission.fleet if drone.id in ids]
        self.world_there = World(fleet, seed=mission.seed + 1, visuals=False)
        self.server = self.world_there.serve(port=0, silence=SILENCE_S)
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
        if self.goes_on:  # in a thread of its own: two must not step one world
            end = self.world_there.time + seconds
            while self.world_there.time < end:
                time.sleep(0.001)
            return
        self.world_there.run(seconds)
        wait_for_odometry(self.handler, self.world_there)

    def unlock(self, indices):
        with self.going_on():
            return super().unlock(indices)

    def close(self):
        with self.going_on():
            super().close()
        self.server.close()

    @contextmanager
    def going_on(self):
        was, self.goes_on = self.goes_on, True
        try:
            if was:
                yield
            else:
                with GoingOn(self.world_there):
                    yield
        finally:
            self.goes_on = was
