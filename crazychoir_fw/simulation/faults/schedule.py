"""The faults of a world, and when they happen."""

from __future__ import annotations

from functools import partial

import numpy as np

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.simulation.drone import Drone
from crazychoir_fw.simulation.faults.fault import Fault
from crazychoir_fw.simulation.faults.kick import kick
from crazychoir_fw.simulation.faults.radio import Radio, RadioFault
from crazychoir_fw.simulation.world_base import WorldBase


class FaultSchedule:
    """Puts faults on the agenda of a world, and notes their begins and ends among its events.

    What a fault does to a drone lives in the drone and in mjData, and comes back with a snapshot; begins and ends stay
    on the agenda, so that a world that goes back in time meets them again.
    """

    def __init__(self, world: WorldBase) -> None:
        self._world = world
        self._radios: dict[str, Radio] = {}
        self.planned: list[Fault] = []
        """All faults, in the order of their coming; a fault's place here and the seed of the world make its seed."""
        for drone in world.drones:
            drone.uplink.handle("kick", partial(kick, world.model, world.data, drone.id))
        world.agenda.when_sought.append(self._time_has_changed)

    def add(self, fault: Fault) -> None:
        """Plan a fault; one that is due at the present tick begins at once.

        Raises:
            RangeError: If its time is over.
            UnknownNameError: If it names a drone that does not exist.
            StateError: If a drone cannot have it.
        """
        world = self._world
        if fault.begin_tick < world.tick:
            raise RangeError(f"{fault.kind}: at is {fault.at} s, allowed: the present time {world.time:.3f} s or later")
        drones = self.check(fault)
        self._plan(fault, drones, from_tick=world.tick)
        if fault.begin_tick == world.tick:
            world.agenda.keep(world.tick)

    def check(self, fault: Fault) -> list[Drone]:
        """Return the drones with the fault.

        Raises:
            UnknownNameError: If it names a drone that does not exist.
            StateError: If a drone cannot have it.
        """
        drones = self._befallen(fault)
        for drone in drones:
            fault.check(drone)
        return drones

    def go_on_from(self, other: FaultSchedule) -> None:
        """Plan in a fork what is still to come of the faults of the world that it comes from."""
        for fault in other.planned:
            self._plan(fault, self._befallen(fault), from_tick=self._world.tick + 1)

    def _plan(self, fault: Fault, drones: list[Drone], from_tick: int) -> None:
        seed = self._seed_of(len(self.planned))
        self.planned.append(fault)
        if isinstance(fault, RadioFault):
            self._listen(fault, drones, seed)
        agenda = self._world.agenda
        if fault.begin_tick >= from_tick:
            agenda.at(fault.begin_tick, partial(self._begin, fault, drones, seed))
        if fault.end_tick is not None and fault.end_tick >= from_tick:
            agenda.at(fault.end_tick, partial(self._end, fault, drones))

    def _befallen(self, fault: Fault) -> list[Drone]:
        if fault.drones is None:
            return list(self._world.drones)
        try:
            return [self._world[name] for name in dict.fromkeys(fault.drones)]
        except UnknownNameError as error:
            raise UnknownNameError(f"{fault.kind}: {error}") from None

    def _seed_of(self, index: int) -> int:
        """Return the seed of a fault, 64 bits."""
        return int(np.random.SeedSequence([self._world.seed, index]).generate_state(1, np.uint64)[0])

    def _listen(self, fault: RadioFault, drones: list[Drone], seed: int) -> None:
        numbers = {drone.id: number for number, drone in enumerate(self._world.drones)}
        for drone in drones:
            if drone.id not in self._radios:
                self._radios[drone.id] = Radio(self._world, drone, numbers[drone.id])
            self._radios[drone.id].add(fault, seed)

    def _begin(self, fault: Fault, drones: list[Drone], seed: int) -> None:
        state = "happens" if fault.is_instant else "begins"
        for drone in drones:
            self._world.note("fault", drone.id, fault=fault.kind, state=state, **fault.details())
            fault.begin(drone, seed)

    def _end(self, fault: Fault, drones: list[Drone]) -> None:
        for drone in drones:
            self._world.note("fault", drone.id, fault=fault.kind, state="ends")
            fault.end(drone)

    def _time_has_changed(self, tick: int) -> None:
        for radio in self._radios.values():
            radio.time_has_changed(tick)
