"""`SimBackend`: drones of a simulated world, with their onboard software."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.checkpoint import Stateful
from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError
from crazychoir_fw.common.messages import Pose, TrajectoryPoint, Twist
from crazychoir_fw.common.ticks import TICKS_PER_SECOND
from crazychoir_fw.flight.backend import Indices, one_of
from crazychoir_fw.flight.setpoints import setpoints
from crazychoir_fw.onboard.core import check
from crazychoir_fw.recording.journal import Journal
from crazychoir_fw.simulation.recorder import FlightRecorder
from crazychoir_fw.simulation.supervisor_resets import is_about_to_reset, is_resetting
from crazychoir_fw.simulation.swarm_views import swarm_parts
from crazychoir_fw.simulation.world import World

if TYPE_CHECKING:
    from crazychoir_fw.recording.flight_log import FlightLog
    from crazychoir_fw.recording.log_stream import LogStream

Array = NDArray[np.float64]

_PLACE = ("stateEstimate.x", "stateEstimate.y", "stateEstimate.z")
_ATTITUDE = ("stateEstimate.qx", "stateEstimate.qy", "stateEstimate.qz", "stateEstimate.qw")
_VELOCITY = ("stateEstimate.vx", "stateEstimate.vy", "stateEstimate.vz")
_GYRO = ("gyro.x", "gyro.y", "gyro.z")
_KEPT = ("read_poses", "_readying", "_goals", "_refusals")  # beside the world
_READY_S = 1.0  # a reset of the supervisor is over long before
_IDENTITY = np.array([0.0, 0.0, 0.0, 1.0])


class SimBackend(Stateful):
    """Commands go through the uplink of each drone, so that the journal of the world proves the flight."""

    is_real_time = False

    def __init__(self, world: World, odometry: str = "estimate", log_rate: int = 100) -> None:
        """Take the drones of a world that are ready to fly (`World.wait_until_ready`).

        Args:
            world: The world; stepped by `advance`.
            odometry: ``estimate`` of the onboard filter and gyroscope, or ``truth``.
            log_rate: Samples of the log per second (Hz).

        Raises:
            RangeError: If the odometry is neither, or a drone has a controller that follows no such commands.
        """
        if odometry not in ("estimate", "truth"):
            raise RangeError(f"odometry is {odometry!r}, allowed: estimate, truth")
        self.world = world
        self.names = [drone.id for drone in world.drones]
        self.masses = np.array([drone.mass for drone in world.drones])
        self.read_poses: Callable[[], Pose] = truth(world) if odometry == "truth" else estimates(world)
        """Returns the poses that the layers receive."""
        self.radio: Any = None
        """The simulated radios, if requests go through some."""
        self.faults: list[dict[str, Any]] = []
        """What is planned to go wrong, in times of the world."""
        self._true = truth(world)
        facts = [lib.cf_platform_facts(drone.struct.config.platform) for drone in world.drones]
        self._max_thrust = np.array([4.0 * float(fact.thrust.thrust_max) for fact in facts])
        self._must_be_armed = [bool(fact.requires_arming) for fact in facts]
        # of drones whose supervisor resets while they are to take off, with the time (s) since which they wait
        self._readying: dict[int, float] = {}
        self._goals: dict[int, tuple[float, TrajectoryPoint]] = {}
        self._refusals: dict[int, str] = {}
        self._structs = ffi.new("cf_t *[]", [drone.struct for drone in world.drones])
        self._recorder = FlightRecorder(world, log_rate)

    @property
    def time(self) -> float:
        """See `Backend`."""
        return self.world.time

    def poses(self) -> Pose:
        """See `Backend`."""
        return self.read_poses()

    def pose_of(self, index: int) -> Pose:
        """See `Backend`."""
        return one_of(self.poses(), index)

    def true_poses(self) -> Pose:
        """Return where all drones are and how they move."""
        return self._true()

    def true_positions(self) -> Array:
        """See `Backend`."""
        return self._true().position

    def unlock(self, indices: Indices) -> list[int]:
        """See `Backend`; drones whose supervisor resets just now are ready within 0.2 s."""
        chosen = [int(i) for i in indices]
        for i in chosen:
            self._refusals.pop(i, None)
            self._readying[i] = self.time
            self._make_ready(i)
        refused = [i for i in chosen if not self._will_fly(i)]
        for i in refused:
            self._readying.pop(i, None)
        return refused

    def _will_fly(self, index: int) -> bool:
        drone = self.world.drones[index]
        return drone.can_fly or is_resetting(drone)

    def _make_ready(self, index: int) -> bool:
        """Arm a drone that must be; return whether it takes commands and no reset is about to drop them."""
        drone = self.world.drones[index]
        if self._must_be_armed[index] and not drone.can_fly and drone.can_arm:
            drone.arm()
        is_ready = drone.can_fly and not is_about_to_reset(drone)
        if is_ready:
            self._readying.pop(index, None)
        return is_ready

    def send(self, indices: Indices, twist: Twist, kind: str) -> None:
        """See `Backend`.

        Raises:
            RangeError: If a number is not finite.
        """
        self.world.send_setpoints(indices, setpoints(twist, kind, self._max_thrust[indices], self.world.tick))

    def go_to(self, index: int, point: TrajectoryPoint) -> None:
        """See `Backend`; a drone whose supervisor resets just now flies there as soon as it can.

        Raises:
            StateError: If the motors may not run.
        """
        drone = self.world.drones[index]
        if not self._will_fly(index):
            raise StateError(f"{drone.id}: the motors may not run, state '{drone.supervisor_state}'")
        self._goals[index] = self.time, point
        self._try(index)

    def land(self, index: int, floor: float, seconds: float) -> None:
        """See `Backend`: by the planner on board."""
        believed = self.world.drones[index].log
        place = np.array([believed["stateEstimate.x"], believed["stateEstimate.y"], floor], float)
        self.go_to(index, TrajectoryPoint(seconds, place))

    def _try(self, index: int) -> None:
        """Hand a goal to a drone, unless its supervisor would drop it."""
        drone = self.world.drones[index]
        if not self._make_ready(index) or drone.struct.onboard.high_level.is_blocked:
            return
        _, point = self._goals.pop(index)
        if drone.struct.onboard.commander.priority > lib.COMMANDER_PRIORITY_HIGHLEVEL:
            drone.uplink.request("cf_notify_setpoint_stop")
        x, y, z = (float(value) for value in point.position)
        status = drone.uplink.request("cf_go_to", x, y, z, 0.0, float(point.time_s), False, False)
        check(status, f"{drone.id}: go_to({x}, {y}, {z}, {point.time_s})")

    def advance(self, seconds: float) -> None:
        """See `Backend`."""
        self.world.step(round(seconds * TICKS_PER_SECOND))
        if self._readying or self._goals:
            self._go_on_waiting()

    def _go_on_waiting(self) -> None:
        for i in list(self._readying):
            self._make_ready(i)
        for i in list(self._goals):
            try:
                self._try(i)
            except CrazychoirError as error:
                self._refusals[i] = str(error)

    def stop(self, indices: Indices) -> None:
        """See `Backend`."""
        for i in indices:
            self._readying.pop(int(i), None)
            self._goals.pop(int(i), None)
            uplink = self.world.drones[i].uplink
            uplink.request("cf_send_stop")
            # the planner, at rest, keeps the watchdog on board quiet
            uplink.request("cf_notify_setpoint_stop")
            if self._must_be_armed[i]:
                uplink.request("cf_arm", False)

    def failures(self) -> dict[int, str]:
        """See `Backend`."""
        now = self.time
        out: list[int] = []
        if lib.cf_count_out(self._structs, len(self._structs)):
            out = [i for i, struct in enumerate(self._structs) if lib.cf_is_out(struct)]
        found = {i: sentence for i in out if (sentence := self.world.drones[i].outage(now)) is not None}
        found.update(self._refusals)
        for i, since in self._readying.items():
            if now - since > _READY_S:
                drone = self.world.drones[i]
                found.setdefault(i, f"{drone.id}: the motors may not run, state '{drone.supervisor_state}'")
        return found

    def record(self, extra: dict[str, Array]) -> None:
        """See `Backend`."""
        self._recorder.sample(extra)

    def run_alone(self, count: int) -> tuple[int, float]:
        """Advance and record while Python has nothing to do, see `FlightRecorder.run_alone`."""
        if self._readying or self._goals or self.radio is not None:
            return 0, 0.0
        return self._recorder.run_alone(count)

    def write_to(self, stream: LogStream, metadata: dict[str, Any]) -> None:
        """See `Backend`."""
        self._recorder.write_to(stream, metadata)

    def flush(self) -> None:
        """See `Backend`."""
        self._recorder.flush()

    def log(self, metadata: dict[str, Any]) -> FlightLog:
        """See `Backend`."""
        return self._recorder.finish(metadata)

    def state(self) -> dict[str, Any]:
        """See `Stateful`. The journal is cleared: an hour of it would be copied into every state otherwise."""
        self.world.journal = Journal(self.world.journal.recipe)
        return {"world": self.world.snapshot(), **{name: getattr(self, name) for name in _KEPT}}

    def restore(self, state: dict[str, Any]) -> None:
        """See `Stateful`."""
        self.world.restore(state["world"])
        vars(self).update({name: state[name] for name in _KEPT})

    def close(self) -> None:
        """See `Backend`."""


def truth(world: World) -> Callable[[], Pose]:
    """Return what reads the true poses of all drones."""
    qpos = np.array([drone.qpos_address for drone in world.drones])[:, None] + np.array([0, 1, 2, 4, 5, 6, 3])
    qvel = np.array([drone.qvel_address for drone in world.drones])[:, None] + np.arange(6)

    def read() -> Pose:
        pose, motion = world.data.qpos[qpos], world.data.qvel[qvel]
        return Pose(pose[:, :3], pose[:, 3:], motion[:, :3], motion[:, 3:], world.time)

    return read


def estimates(world: World) -> Callable[[], Pose]:
    """Return what reads the poses of all drones as their onboard software believes them."""
    position, orientation, velocity, rates = (_reader(world, names) for names in (_PLACE, _ATTITUDE, _VELOCITY, _GYRO))
    size = len(world.drones)

    def read() -> Pose:
        quat = orientation()
        # before the filter runs, all four are zero; of an attitude w is at half turns only, and looked at in no time
        if np.count_nonzero(quat[:, 3]) < size:
            quat = np.where(quat.any(axis=1)[:, None], quat, _IDENTITY)
        return Pose(position(), quat, velocity(), np.radians(rates()), world.time)

    return read


def _reader(world: World, names: Sequence[str]) -> Callable[[], Array]:
    """Return what reads some log variables of all drones, shape (N, len(names))."""
    parts = swarm_parts(world)
    if len(parts) == 1:
        return parts[0].gather(names)
    blocks = [(part.numbers, part.gather(names)) for part in parts]

    def read() -> Array:
        values = np.empty((len(world.drones), len(names)))
        for rows, gather in blocks:
            values[rows] = gather()
        return values

    return read
