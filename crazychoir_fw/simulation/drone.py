"""One drone of a world: what a client sees of it, and what only the simulator knows."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import CrazychoirError, RangeError, StateError
from crazychoir_fw.onboard.core import PLUGIN, address_of, check, receive_packet, struct_view
from crazychoir_fw.onboard.variables import log_table, parameter_table
from crazychoir_fw.simulation.clients import Commander, HighLevelCommander, Localization, Log, Param, Uplink
from crazychoir_fw.simulation.drone_config import DroneConfig
from crazychoir_fw.simulation.lights import Lights
from crazychoir_fw.simulation.loading import Payload, drop_payload, hook_of
from crazychoir_fw.simulation.state_check import check_kind, check_memory

if TYPE_CHECKING:
    from crazychoir_fw.simulation.cameras import Camera, Cameras


class DroneSnapshot:
    """Everything that one drone is at one instant: onboard software, vehicle and motion."""

    def __init__(self, state: NDArray[np.uint8], qpos: NDArray[np.float64], qvel: NDArray[np.float64]) -> None:
        self.state = state.copy()
        self.qpos = qpos.copy()
        self.qvel = qvel.copy()


class Drone:
    """A handle of one drone; its memory belongs to the `mjData` of its world."""

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, config: DroneConfig, watched: dict[str, Param] | None = None
    ) -> None:
        self._model, self._data = model, data  # keep the memory alive
        self.config = config
        self.id = config.id
        qpos, qvel, state = body_addresses(model, config.id)
        self.qpos_address = qpos
        self.qvel_address = qvel
        size = int(model.plugin_statenum[model.body_plugin[model.body(config.id).id]])
        self._qpos = data.qpos[qpos : qpos + 7]
        self._qvel = data.qvel[qvel : qvel + 6]
        self._qacc = data.qacc[qvel : qvel + 6]
        self._subtree_mass = model.body_subtreemass[model.body(config.id).id :][:1]
        self._place_of_state = slice(state, state + size)
        self.memory: NDArray[np.uint8] = data.plugin_state[self._place_of_state].view(np.uint8)
        self._cf: Any = struct_view("cf_t", address_of(self.memory))

        is_detachable = bool(config.payload and config.payload.get("detachable"))
        self.payload = Payload(model, data, config.id) if is_detachable else None
        """What hangs on its hook, where that can be detached."""

        self.provider_number = int(self._cf.config.provider)
        """Number of its provider in the core (`crazychoir_fw.onboard.core.provider_identity`)."""
        provider = self.provider_number
        self.uplink = Uplink(self._cf)
        """The way of all requests: code that listens to commands, or disturbs them, hooks in here."""
        self.uplink.handle("packet", self._receive_packet)
        self.uplink.handle("setpoint", self._receive_setpoint)
        self.uplink.handle("place", self._place)
        self.uplink.handle("restore", self._restore)
        self.uplink.handle("link_statistics", self._note_link)
        self.uplink.handle("drop_payload", partial(drop_payload, model, data, config.id))
        self.commander = Commander(self.id, self.uplink)
        self.high_level_commander = HighLevelCommander(self.id, self._cf, self.uplink)
        self.loc = Localization(self.id, self._cf, self.uplink)
        watched = {} if watched is None else watched
        self.param = Param(self.id, self.memory, parameter_table(provider), self._cf, watched, self.uplink)
        self.log = Log(self.id, self.memory, log_table(provider), self._cf)
        self.lights = Lights(self._cf)
        """What clients have written for its LED ring."""
        self.cameras: Cameras | None = None
        """What the cameras of its world share; the world sets it."""
        self.motor_ctrl: Any = None
        """The `MotorCtrl` that flies it from Python, if the configuration names one."""

    def __repr__(self) -> str:
        x, y, z = self.true_position
        return f"<Drone {self.id} ({self.config.platform}) at {x:.2f}, {y:.2f}, {z:.2f} m: {self.supervisor_state}>"

    @property
    def struct(self) -> Any:
        """The drone as a cffi pointer to ``cf_t``, for tests of a part of it."""
        return self._cf

    # ---------------------------------------------------------------- what only the simulator knows

    @property
    def true_position(self) -> NDArray[np.float64]:
        """Position of the body (m, world), shape (3,)."""
        return self._qpos[:3].copy()

    @property
    def true_velocity(self) -> NDArray[np.float64]:
        """Velocity of the body (m/s, world), shape (3,)."""
        return self._qvel[:3].copy()

    @property
    def true_acceleration(self) -> NDArray[np.float64]:
        """Acceleration of the body over the last step (m/s^2, world), shape (3,)."""
        return self._qacc[:3].copy()

    @property
    def mass(self) -> float:
        """Mass of the body with everything on it (kg)."""
        return float(self._subtree_mass[0])

    @property
    def true_quat_wxyz(self) -> NDArray[np.float64]:
        """Attitude, body to world, shape (4,)."""
        return self._qpos[3:7].copy()

    @property
    def true_rates(self) -> NDArray[np.float64]:
        """Angular velocity (rad/s, body), shape (3,)."""
        return self._qvel[3:6].copy()

    # ---------------------------------------------------------------- what the drone believes and is

    @property
    def estimated_position(self) -> NDArray[np.float64]:
        """Position by the state estimator (m, world), shape (3,)."""
        position = self._cf.onboard.estimate.position
        return np.array([position.x, position.y, position.z])

    @property
    def supervisor_state(self) -> str:
        """State of the supervisor in words, e.g. ``Flying``."""
        return ffi.string(lib.supervisorGetStateName(self._cf.onboard.supervisor.state)).decode()

    @property
    def can_fly(self) -> bool:
        """Whether the motors may run."""
        return bool(lib.cf_supervisor_are_motors_allowed(self._supervisor))

    @property
    def can_arm(self) -> bool:
        """Whether a request to arm would be granted."""
        return bool(lib.cf_supervisor_can_arm(self._supervisor))

    @property
    def is_flying(self) -> bool:
        """Whether the supervisor sees the drone flying."""
        return bool(lib.cf_supervisor_is_flying(self._supervisor))

    @property
    def is_crashed(self) -> bool:
        """Whether the supervisor has seen a crash."""
        return bool(lib.cf_supervisor_is_crashed(self._supervisor))

    @property
    def is_locked(self) -> bool:
        """Whether only a reboot helps."""
        return bool(lib.cf_supervisor_is_locked(self._supervisor))

    @property
    def failure(self) -> str | None:
        """Why the core stopped this drone for good, as a sentence, or None."""
        onboard = self._cf.onboard
        if onboard.fault == lib.CF_FAULT_NONE:
            return None
        reason = ffi.string(lib.cf_fault_text(onboard.fault)).decode()
        if onboard.fault in (lib.CF_FAULT_SOFTWARE, lib.CF_FAULT_PILOT):
            reason += f": {ffi.string(onboard.failure).decode(errors='replace')}"
        return f"{self.id}: {reason} (at {onboard.fault_tick / 1000:.3f} s)"

    def outage(self, now: float) -> str | None:
        """Return why the drone cannot fly any more, a sentence: failed, crashed or locked up; None while it can.

        Args:
            now: Time (s), for the sentence.
        """
        if not lib.cf_is_out(self._cf):
            return None
        return self.failure or f"{self.id}: {'crashed' if self.is_crashed else 'locked up'} at {now:.2f} s"

    @property
    def console(self) -> str:
        """The latest 512 characters that the onboard software printed."""
        console = ffi.addressof(self._cf.onboard, "console")
        text, first = ffi.new("char[]", lib.CF_CONSOLE_BYTES), ffi.new("uint32_t *")
        count = lib.cf_console_read(console, 0, text, lib.CF_CONSOLE_BYTES, first)
        return ffi.unpack(text, count).decode("ascii", "replace")

    @property
    def peers(self) -> NDArray[np.float64]:
        """Positions of other drones that this drone has received (m, world), shape (n, 3), n at most 10.

        The world sends them 100 times a second, but only while the drone's parameter ``colAv.enable`` is set.
        """
        told = [peer.pos for peer in self._cf.onboard.peers.peers if peer.id]
        return np.array([(position.x, position.y, position.z) for position in told]).reshape(-1, 3)

    @property
    def battery_voltage(self) -> float:
        """Voltage at the terminals of the battery (V)."""
        return float(self._cf.vehicle.battery.voltage)

    def camera(
        self,
        name: str = "fpv",
        width: int | None = None,
        height: int | None = None,
        *,
        fov_deg: float | None = None,
        tilt_deg: float = 0.0,
    ) -> Camera:
        """Return a camera that goes with this drone.

        Args:
            name: ``fpv`` is mounted at its nose and looks forward; ``chase`` flies behind it, follows its yaw and stays
                level; else a camera of the model, first one of this drone (``<camera name="cf1/down">`` is ``down``).
            width: Width of its pictures (pixels); by default 324 on board and 640 behind.
            height: Height of its pictures (pixels); by default 244 on board and 360 behind.
            fov_deg: Angle between the lower and the upper edge of the picture; by default 55 on board, 45 behind.
            tilt_deg: How far ``fpv`` is tilted upward, -90 looks straight down.

        Raises:
            RangeError: If a value is outside its range.
            UnknownNameError: If there is no such camera.
            StateError: If the drone belongs to no world.
        """
        if self.cameras is None:
            raise StateError(f"{self.id}: belongs to no world that has cameras")
        return self.cameras.on_board(self.id, name, width, height, fov_deg, tilt_deg)

    @property
    def _supervisor(self) -> Any:
        return ffi.addressof(self._cf.onboard, "supervisor")

    # ---------------------------------------------------------------- requests

    def arm(self, do_arm: bool = True) -> None:
        """Arm or disarm, as cflib's `supervisor.send_arming_request`.

        Raises:
            StateError: If the drone cannot be armed in its present state.
        """
        if self.uplink.request("cf_arm", do_arm) != lib.CF_OK:
            raise StateError(f"{self.id}: cannot be armed in state '{self.supervisor_state}'")

    def recover_from_crash(self) -> None:
        """Clear a crash; refused while the drone still lies tumbled."""
        if self.uplink.request("cf_recover_from_crash") != lib.CF_OK:
            raise StateError(f"{self.id}: cannot recover while it lies tumbled")

    def emergency_stop(self) -> None:
        """Stop the motors and lock the drone until it is rebooted.

        The drone is disarmed too: for 3 s after a landing the firmware does not look for emergency stops, and leaves
        that state at once when it is not armed (docs/reference/planner-commander.md#14.5).
        """
        self.uplink.request("cf_emergency_stop")
        self.uplink.request("cf_arm", False)

    def reboot(self) -> None:
        """Boot the onboard software again; battery, rotors and motion go on."""
        self.uplink.dispatch("cf_reboot")

    def send_extpos(self, x: float, y: float, z: float) -> None:
        """Tell the drone its position (m, world), as cflib's `extpos.send_extpos`."""
        status = self.uplink.request("cf_send_external_position", x, y, z)
        check(status, f"{self.id}: send_extpos({x}, {y}, {z})")

    def send_extpose(self, x: float, y: float, z: float, qx: float, qy: float, qz: float, qw: float) -> None:
        """Tell the drone its pose (m, quaternion xyzw), as cflib's `extpos.send_extpose`."""
        status = self.uplink.request("cf_send_external_pose", x, y, z, [qx, qy, qz, qw])
        check(status, f"{self.id}: send_extpose({x}, {y}, {z}, …)")

    def receive_packet(self, port: int, channel: int, data: bytes) -> bytes | None:
        """Hand over a CRTP packet as the radio would, and return the payload of the answer, or None.

        Ports 3 and 7 (setpoints), 6 (localization), 8 (high-level commander) and 9 (supervisor).

        Raises:
            RangeError: If the packet has a wrong length, or a number in it is not finite.
            UnknownNameError: If there is no such port, channel or type.
            StateError: If the drone refuses it in its present state.
        """
        return self.uplink.request("packet", port, channel, data) or None

    def _receive_packet(self, port: int, channel: int, data: bytes, call: str | None = None) -> bytes | None:
        call = call or f"packet '{data.hex(' ')}' on port {port} channel {channel}"
        return receive_packet(self._cf, port, channel, data, f"{self.id}: {call}")

    def _receive_setpoint(self, data: bytes) -> int:
        return lib.cf_send_setpoint_bytes(self._cf, data, len(data))

    # ---------------------------------------------------------------- what happens to it

    def _note_link(self, rssi: int, is_connected: bool, received: int, receive_rate: int, transmit_rate: int) -> None:
        """Take the numbers of the simulated radio: log groups ``radio`` and ``crtp``."""
        system = self._cf.onboard.system
        system.radio_rssi = rssi
        system.radio_is_connected = is_connected
        system.radio_received_unicasts = received
        system.crtp_receive_rate = receive_rate
        system.crtp_transmit_rate = transmit_rate

    def blow_gust(self, peak: tuple[float, float, float], duration_s: float) -> None:
        """Let a gust begin now: the wind rises by `peak` (m/s, world) and is back after `duration_s`, as 1 - cosine.

        Raises:
            RangeError: If a component is beyond 50 m/s, or the duration outside 0.001 to 3600 s.
        """
        ticks = round(duration_s * 1000) if 0.0 < duration_s < 1e6 else 0
        status = self.uplink.dispatch("cf_inject_gust", [float(speed) for speed in peak], ticks)
        allowed = "allowed: -50 to 50 m/s, 0.001 to 3600 s"
        check(status, f"{self.id}: blow_gust({peak}, {duration_s}) ({allowed})")

    @property
    def has_hook(self) -> bool:
        """Whether the model has a payload of this drone that can be dropped."""
        return hook_of(self._model, self.id) >= 0

    def drop_payload(self) -> None:
        """Let the payload fall.

        Raises:
            StateError: If there is none that can be detached, or it has been dropped.
        """
        if self.payload is None:
            raise StateError(f"{self.id}: carries nothing detachable; configure payload with detachable: true")
        if not self.payload.is_attached:
            raise StateError(f"{self.id}: has dropped its payload already")
        self.uplink.dispatch("drop_payload")

    # ---------------------------------------------------------------- snapshots

    def place(self, position: NDArray[np.float64] | tuple[float, float, float], yaw_deg: float = 0.0) -> None:
        """Put the body somewhere else (m, world; deg), at rest and level."""
        if not np.all(np.isfinite([*position, yaw_deg])):
            raise RangeError(f"{self.id}: place({position}, {yaw_deg}): allowed: finite numbers")
        self.uplink.dispatch("place", [float(number) for number in position], float(yaw_deg))

    def _place(self, position: list[float], yaw_deg: float) -> None:
        half_yaw = np.radians(yaw_deg) / 2
        self._qpos[:] = [*position, np.cos(half_yaw), 0.0, 0.0, np.sin(half_yaw)]
        self._qvel[:] = 0.0
        if self.payload is not None:
            self.payload.follow(self._qpos)
        self._cf.has_last_velocity = False

    def snapshot(self) -> DroneSnapshot:
        """Return everything that this drone is."""
        return DroneSnapshot(self.memory, self._qpos, self._qvel)

    def restore(self, snapshot: DroneSnapshot) -> None:
        """Make the drone what it was. A flight in which that was done cannot be replayed from its journal.

        Raises:
            RangeError: If the snapshot is one of another provider or platform.
        """
        if len(snapshot.state) != len(self.memory):
            raise RangeError(f"{self.id}: the snapshot has {len(snapshot.state)} bytes, allowed: {len(self.memory)}")
        check_kind(snapshot.state, self.id, *self._kind)
        self.uplink.dispatch("restore", snapshot)

    def check_memory(self, plugin_state: NDArray[np.float64]) -> None:
        """Refuse memory from a file that C could not work with.

        Args:
            plugin_state: Memory of all plugins, as in ``mjData.plugin_state``.

        Raises:
            RangeError: See `crazychoir_fw.simulation.state_check`.
        """
        check_memory(plugin_state[self._place_of_state].view(np.uint8), self.id, *self._kind)

    @property
    def _kind(self) -> tuple[int, int]:
        return self.provider_number, int(self._cf.config.platform)

    def _restore(self, snapshot: DroneSnapshot) -> None:
        self.memory[:] = snapshot.state
        self._qpos[:] = snapshot.qpos
        self._qvel[:] = snapshot.qvel


def body_addresses(model: mujoco.MjModel, name: str) -> tuple[int, int, int]:
    """Return where a drone lives: address in qpos, in qvel and in plugin_state.

    Raises:
        CrazychoirError: If the body carries no Crazyflie.
    """
    body = model.body(name)
    instance = int(model.body_plugin[body.id])
    if instance < 0:
        raise CrazychoirError(f"{name}: the body carries no {PLUGIN}")
    joint = int(model.body_jntadr[body.id])
    return int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint]), int(model.plugin_stateadr[instance])
