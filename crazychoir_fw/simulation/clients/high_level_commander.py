"""Plans of one drone: take-off, landing, go-to, spirals, uploaded trajectories."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, StateError
from crazychoir_fw.onboard.core import check
from crazychoir_fw.onboard.trajectories import CompressedSegment, CompressedStart, Poly4D, pack_compressed
from crazychoir_fw.simulation.clients.uplink import Uplink

_PIECE_FLOATS = 33  # 8 coefficients of x, y, z and yaw, then the duration


class HighLevelCommander:
    """Take-off, landing, go-to, spirals and uploaded trajectories, flown by the onboard planner."""

    ALL_GROUPS = 0
    TRAJECTORY_TYPE_POLY4D = int(lib.CF_TRAJECTORY_TYPE_POLY4D)
    TRAJECTORY_TYPE_POLY4D_COMPRESSED = int(lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED)

    def __init__(self, name: str, cf: Any, uplink: Uplink) -> None:
        self._name = name
        self._cf = cf
        self._uplink = uplink

    def _check(self, status: int, call: str) -> None:
        if status == lib.CF_ERR_STATE:
            reason = "a take-off needs a stopped planner" if call.startswith("takeoff") else "already landing"
            raise StateError(f"{self._name}: {call} is refused: {reason}")
        check(status, f"{self._name}: {call}")

    def set_group_mask(self, group_mask: int = ALL_GROUPS) -> None:
        """Choose the groups of this drone, one per bit; commands for one of them, or for 0 = all, are obeyed."""
        if not 0 <= group_mask <= 255:
            raise RangeError(f"{self._name}: group_mask {group_mask} is outside [0, 255]")
        self._uplink.request("cf_set_group_mask", int(group_mask))

    def takeoff(
        self, absolute_height_m: float, duration_s: float, group_mask: int = 0, yaw: float | None = 0.0
    ) -> None:
        """Rise straight up to a height (m, world), turning to yaw (rad; None keeps the present one)."""
        if not self._is_meant(group_mask):
            return
        status = self._uplink.request("cf_takeoff", absolute_height_m, duration_s, yaw or 0.0, yaw is None)
        self._check(status, f"takeoff(absolute_height_m={absolute_height_m}, duration_s={duration_s})")

    def land(self, absolute_height_m: float, duration_s: float, group_mask: int = 0, yaw: float | None = 0.0) -> None:
        """Sink straight down to a height (m, world); then the motors stop."""
        if not self._is_meant(group_mask):
            return
        status = self._uplink.request("cf_land", absolute_height_m, duration_s, yaw or 0.0, yaw is None)
        self._check(status, f"land(absolute_height_m={absolute_height_m}, duration_s={duration_s})")

    def stop(self, group_mask: int = 0) -> None:
        """Stop the motors at once."""
        if self._is_meant(group_mask):
            self._check(self._uplink.request("cf_stop"), "stop()")

    def go_to(
        self,
        x: float,
        y: float,
        z: float,
        yaw: float,
        duration_s: float,
        relative: bool = False,
        linear: bool = False,
        group_mask: int = 0,
    ) -> None:
        """Fly to a position (m) and yaw (rad); relative ones count from the present setpoint."""
        if not self._is_meant(group_mask):
            return
        status = self._uplink.request("cf_go_to", x, y, z, yaw, duration_s, relative, linear)
        self._check(status, f"go_to({x}, {y}, {z}, yaw={yaw}, duration_s={duration_s})")

    def spiral(
        self,
        angle: float,
        r0: float,
        rF: float,
        ascent: float,
        duration_s: float,
        sideways: bool = False,
        clockwise: bool = False,
        group_mask: int = 0,
    ) -> None:
        """Fly a spiral about a vertical axis from the present setpoint.

        Args:
            angle: Angle of the spiral (rad); beyond a full turn it becomes one.
            r0: Radius at the begin (m); a negative one becomes 0.
            rF: Radius at the end (m); a negative one becomes 0.
            ascent: Height gained (m); negative descends.
            duration_s: Duration (s).
            sideways: Fly to the left, with the nose along the radius, instead of forward along the path.
            clockwise: Turn to the right instead of to the left.
            group_mask: Groups that are meant; 0 is all.
        """
        if not self._is_meant(group_mask):
            return
        spiral = [[sideways, clockwise, angle, r0, rF, ascent, duration_s]]
        self._check(self._uplink.request("cf_spiral", spiral), f"spiral({angle}, {r0}, {rF}, {ascent}, {duration_s})")

    def upload_trajectory(self, trajectory_id: int, pieces: ArrayLike | Sequence[Poly4D], offset: int = 0) -> float:
        """Write polynomial pieces into trajectory memory and define them as one trajectory.

        Args:
            trajectory_id: 0 to 30.
            pieces: Shape (n, 33): for each piece 8 ascending coefficients of x, y, z (m) and yaw (rad), then the
                duration (s). Or a list of `Poly4D`.
            offset: Place in the memory of 4096 bytes, a multiple of 4.

        Returns:
            Duration of the trajectory (s).
        """
        if isinstance(pieces, Sequence) and all(isinstance(piece, Poly4D) for piece in pieces):
            packed = b"".join(piece.pack() for piece in pieces)
            pieces = np.frombuffer(packed, dtype="<f4").reshape(-1, _PIECE_FLOATS)
        array = np.ascontiguousarray(pieces, dtype="<f4")
        if array.ndim != 2 or array.shape[1] != _PIECE_FLOATS or not np.all(np.isfinite(array)):
            raise RangeError(f"{self._name}: pieces have shape {array.shape}, allowed: (n, 33) finite numbers")
        what = f"{self._name}: upload_trajectory({trajectory_id}, {len(array)} pieces, offset={offset})"
        self._write_trajectory(trajectory_id, offset, array.tobytes(), what)
        self.define_trajectory(trajectory_id, offset, len(array))
        return float(array[:, -1].sum())

    def upload_compressed_trajectory(
        self, trajectory_id: int, start: CompressedStart, segments: Iterable[CompressedSegment], offset: int = 0
    ) -> float:
        """Write a compressed trajectory into trajectory memory and define it.

        Args:
            trajectory_id: 0 to 30.
            start: Where it starts.
            segments: What follows; 3 to 59 bytes each.
            offset: Place in the memory of 4096 bytes.

        Returns:
            Duration of the trajectory (s).
        """
        segments = list(segments)
        data = pack_compressed(start, segments)
        what = f"{self._name}: upload_compressed_trajectory({trajectory_id}, {len(segments)} segments, offset={offset})"
        self._write_trajectory(trajectory_id, offset, data, what)
        self.define_trajectory(trajectory_id, offset, len(segments), self.TRAJECTORY_TYPE_POLY4D_COMPRESSED)
        return sum(int(segment.duration * 1000.0) for segment in segments) / 1000.0

    def _write_trajectory(self, trajectory_id: int, offset: int, data: bytes, what: str) -> None:
        if not 0 <= trajectory_id <= 30 or not 0 <= offset <= lib.CF_TRAJECTORY_MEMORY_BYTES:
            raise RangeError(f"{what}: allowed: trajectory 0 to 30, offset 0 to 4096")
        check(self._uplink.request("cf_write_trajectory", offset, len(data), data), what)

    def define_trajectory(
        self, trajectory_id: int, offset: int, n_pieces: int, type: int = TRAJECTORY_TYPE_POLY4D
    ) -> None:
        """Name pieces that lie in trajectory memory at offset (bytes); a compressed trajectory ends by itself."""
        what = f"{self._name}: define_trajectory({trajectory_id}, {offset}, {n_pieces}, type={type})"
        if not (0 <= trajectory_id <= 30 and 0 <= offset <= lib.CF_TRAJECTORY_MEMORY_BYTES and 0 <= type <= 1):
            raise RangeError(f"{what}: allowed: trajectory 0 to 30, offset 0 to 4096, type 0 or 1")
        # means nothing to a compressed one, which may have 1000
        n_pieces = min(max(n_pieces, 0), 255)
        check(self._uplink.request("cf_define_trajectory", trajectory_id, type, offset, n_pieces), what)

    def start_trajectory(
        self,
        trajectory_id: int,
        time_scale: float = 1.0,
        relative_position: bool = False,
        relative_yaw: bool = False,
        reversed: bool = False,
        group_mask: int = 0,
    ) -> None:
        """Follow an uploaded trajectory; a time scale above 1 slows it down."""
        if not self._is_meant(group_mask):
            return
        status = self._uplink.request(
            "cf_start_trajectory", trajectory_id, time_scale, relative_position, relative_yaw, reversed
        )
        check(status, f"{self._name}: start_trajectory({trajectory_id}, time_scale={time_scale})")

    @property
    def is_trajectory_finished(self) -> bool:
        """Whether the current plan has come to its end."""
        return bool(lib.cf_is_trajectory_finished(self._cf))

    def _is_meant(self, group_mask: int) -> bool:
        commander = ffi.addressof(self._cf.onboard, "high_level")
        return bool(lib.cf_high_level_commander_is_in_group(commander, group_mask))
