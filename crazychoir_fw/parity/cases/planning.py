"""The planner: take-off, landing, go-to, spirals, polynomial and compressed trajectories, and what it refuses."""

from __future__ import annotations

import functools
from collections.abc import Callable
from typing import Any

import numpy as np

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.onboard.trajectories import pack_compressed
from crazychoir_fw.parity.cases.case import Case, CaseRequest, Outcome
from crazychoir_fw.parity.manoeuvres import example_compressed, example_pieces
from crazychoir_fw.parity.structs import columns, dtype_of

_ALWAYS = (
    "plan_is_stopped",
    "plan_is_disabled",
    "plan_is_finished",
    "plan_state",
    "plan_current_goal",
)
_PERIOD = 0.01  # [s], the planner speaks at 100 Hz
_COMPRESSED_AT = 2049  # odd: compressed bytes need no alignment


class _Planner:
    """The plan functions of a provider, asked for a goal every 10 ms."""

    def __init__(self, request: CaseRequest) -> None:
        self.block = request.boot()
        self._f = self.block.functions
        self.state = self.block.state
        self.memory = ffi.new("uint32_t[]", lib.CF_TRAJECTORY_MEMORY_BYTES // 4)  # aligned as pieces must be
        self.bytes = ffi.cast("uint8_t *", self.memory)
        pieces = example_pieces().astype("<f4").tobytes()
        ffi.memmove(self.bytes, pieces, len(pieces))
        compressed = pack_compressed(*example_compressed())
        ffi.memmove(self.bytes + _COMPRESSED_AT, compressed, len(compressed))
        self.t = 0.0
        self._rows: list[bytes] = []
        self._facts: list[tuple[int, ...]] = []
        self.status = 0

    def start(self, x: float = 0.1, y: float = -0.2, z: float = 0.5, yaw: float = 0.2, speed: float = 0.0) -> Any:
        """Return where a plan starts."""
        return ffi.new("cf_plan_start_t *", {"pos": (x, y, z), "vel": (speed, -speed, 0.5 * speed), "yaw": yaw})

    def call(self, name: str, *arguments: Any) -> None:
        """Ask for a plan; its status is part of the next samples."""
        result = self._f[name](self.state, *arguments)
        self.status = -1 if result is None else int(result)

    def follow(self, seconds: float) -> None:
        """Ask for goals, and what the planner says about itself."""
        f = self._f
        for _ in range(round(seconds / _PERIOD)):
            self.t = float(np.float32(self.t + _PERIOD))
            goal = ffi.new("struct traj_eval *", f["plan_current_goal"](self.state, self.bytes, self.t))
            self._rows.append(bytes(ffi.buffer(goal)))
            self._facts.append(
                (
                    self.status,
                    f["plan_state"](self.state),
                    f["plan_is_stopped"](self.state),
                    f["plan_is_disabled"](self.state),
                    f["plan_is_finished"](self.state, self.bytes, self.t),
                )
            )

    def outcome(self) -> Outcome:
        goals = np.frombuffer(b"".join(self._rows), dtype_of("struct traj_eval"))
        facts = np.array(self._facts, np.int32)
        names = ("status", "state", "is_stopped", "is_disabled", "is_finished")
        signals = {**columns(goals, "goal"), **{name: facts[:, i] for i, name in enumerate(names)}}
        return Outcome(np.arange(len(goals)), signals, self.block.failure)


def planning_cases() -> list[Case]:
    """Return the cases of the planner."""
    scripts: dict[str, tuple[str, Callable[[_Planner], None], tuple[str, ...]]] = {
        "take-off and landing": ("twice, with a second take-off refused", _hop, ("plan_takeoff", "plan_land")),
        "go-to": (
            "smooth, linear and relative, from rest and in flight, 40 random ones",
            _go_to,
            ("plan_takeoff", "plan_go_to"),
        ),
        "spirals": ("forward and sideways, both turns, up and down, beyond a full turn", _spirals, ("plan_spiral",)),
        "polynomials": (
            "uploaded pieces: forward, reversed, scaled, relative in position and yaw",
            _polynomials,
            ("plan_start_trajectory",),
        ),
        "compressed": ("uploaded bytes, absolute and relative", _compressed, ("plan_start_trajectory",)),
        "stop and disable": (
            "in the middle of a plan, and plans after that",
            _stop,
            ("plan_takeoff", "plan_stop", "plan_disable", "plan_go_to"),
        ),
    }
    return [
        Case(
            group="planner",
            name=name,
            about=about,
            run=functools.partial(_run, script=script),
            needs=(*_ALWAYS, *needs),
            by_number=True,
        )
        for name, (about, script, needs) in scripts.items()
    ]


def _run(request: CaseRequest, script: Callable[[_Planner], None]) -> Outcome:
    planner = _Planner(request)
    planner.follow(0.03)  # before there is any plan
    script(planner)
    return planner.outcome()


def _hop(p: _Planner) -> None:
    for height, yaw, duration in ((0.6, 0.2, 1.5), (1.3, -2.5, 2.25)):
        p.call("plan_takeoff", p.start(yaw=0.2), height, yaw, duration, p.t)
        p.follow(duration / 2)
        p.call("plan_takeoff", p.start(), 1.0, 0.0, 1.0, p.t)
        p.follow(duration / 2 + 0.1)
        p.call("plan_land", p.start(z=height, yaw=yaw), 0.05, yaw + 0.5, duration, p.t)
        p.follow(duration / 2)
        p.call("plan_land", p.start(), 0.0, 0.0, 1.0, p.t)
        p.follow(duration / 2 + 0.1)


def _go_to(p: _Planner) -> None:
    dice = np.random.default_rng(11)
    p.call("plan_takeoff", p.start(), 0.7, 0.3, 1.0, p.t)
    p.follow(0.6)
    for i in range(40):
        goal = dict(zip("xyz", dice.uniform(-2.0, 2.0, 3).tolist(), strict=True))
        yaw, duration = float(dice.uniform(-6.0, 6.0)), float(dice.uniform(0.1, 2.0))
        p.call("plan_go_to", p.bytes, p.start(speed=0.3), i % 2 == 1, i % 4 >= 2, goal, yaw, duration, p.t)
        p.follow(duration * (0.5 if i % 3 else 1.1))


def _spirals(p: _Planner) -> None:
    for angle in (0.0, 1.5, -3.0, 6.28, 9.0, -9.0):
        for sideways, clockwise in ((False, False), (True, False), (False, True), (True, True)):
            values = [sideways, clockwise, angle, 0.3, 0.5 if angle > 0 else -0.1, 0.2 if sideways else -0.2, 1.0]
            p.call("plan_spiral", p.start(speed=0.2), ffi.new("cf_spiral_t *", values), p.t)
            p.follow(0.8)


def _uploaded(p: _Planner, kind: int, offset: int, **options: Any) -> None:
    facts = {"type": kind, "offset": offset, "n_pieces": 2, "timescale": 1.0, **options}
    p.call("plan_start_trajectory", p.bytes, ffi.new("cf_uploaded_trajectory_t *", facts), p.start(yaw=0.7), p.t)


def _polynomials(p: _Planner) -> None:
    for timescale in (1.0, 0.5, 1.7):
        for is_reversed in (False, True):
            for position, yaw in ((False, False), (True, False), (True, True), (False, True)):
                _uploaded(
                    p,
                    lib.CF_TRAJECTORY_TYPE_POLY4D,
                    0,
                    timescale=timescale,
                    reversed=is_reversed,
                    relative_position=position,
                    relative_yaw=yaw,
                )
                p.follow(1.8 * timescale + 0.2)


def _compressed(p: _Planner) -> None:
    for is_relative in (False, True):
        _uploaded(p, lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED, _COMPRESSED_AT, relative_position=is_relative)
        p.follow(1.9)


def _stop(p: _Planner) -> None:
    for name in ("plan_stop", "plan_disable"):
        p.call("plan_takeoff", p.start(), 0.7, 0.3, 1.0, p.t)
        p.follow(0.4)
        p.call(name)
        p.follow(0.1)
        p.call("plan_go_to", p.bytes, p.start(), False, False, {"x": 0.5, "y": 0.1, "z": 0.6}, 0.1, 1.0, p.t)
        p.follow(1.2)
        p.call("plan_stop")
        p.follow(0.05)
