"""From plan to plan at any time: no setpoint jumps (docs/reference/planner-commander.md#6 and #7.3).

Positions never jump. Velocities do not either where the firmware plans from the present one, at a smooth go-to;
take-offs and landings start at rest, spirals and trajectories with their own velocity.
"""

import math
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from planning_provider import planning_provider
from setpoint_numbers import setpoint_numbers

from crazychoir_fw._core import ffi, lib

TICK = 0.01  # [s], of the high-level commander
COMPRESSED = lib.CF_TRAJECTORY_TYPE_POLY4D_COMPRESSED


@dataclass
class Flight:
    """A high-level commander that is asked for setpoints at 100 Hz, with the last one before each command."""

    provider: Any = field(default_factory=planning_provider)
    now_us: int = 0
    commander: Any = field(default_factory=lambda: ffi.new("cf_high_level_commander_t *"))
    setpoint: Any = field(default_factory=lambda: ffi.new("setpoint_t *"))
    path: list = field(default_factory=list)

    def __post_init__(self) -> None:
        lib.cf_high_level_commander_init(self.commander)
        self.estimate = ffi.new("state_t *")

    def call(self, name: str, *args) -> None:
        """Give a command at the present instant."""
        function = getattr(lib, f"cf_high_level_commander_{name}")
        assert function(self.commander, self.provider.table, self.provider.state, *args, self.now_us) == lib.CF_OK

    def upload(self, id: int, data: bytes, type: int, n_pieces: int, offset: int) -> None:
        assert lib.cf_high_level_commander_write_trajectory(self.commander, offset, len(data), data) == lib.CF_OK
        define = lib.cf_high_level_commander_define_trajectory
        assert define(self.commander, id, type, offset, n_pieces) == lib.CF_OK

    def sample(self) -> NDArray[np.float64]:
        """Return position and velocity that are asked for now."""
        assert lib.cf_high_level_commander_get_setpoint(
            self.commander, self.provider.table, self.provider.state, self.estimate, 10, self.now_us, self.setpoint
        )
        assert np.isfinite(setpoint_numbers(self.setpoint)).all()
        p, v = self.setpoint.position, self.setpoint.velocity
        return np.array([[p.x, p.y, p.z], [v.x, v.y, v.z]])

    def run(self, ticks: int) -> NDArray[np.float64]:
        """Fly on and return the last sample."""
        for _ in range(ticks):
            self.now_us += 10_000
            self.path.append(self.sample()[0])
        return self.sample()


def line_pieces() -> bytes:
    """Return two uncompressed pieces: 2 s along x at 0.5 m/s, then 2 s along y."""
    pieces = np.zeros((2, 33), dtype="<f4")
    pieces[0, [0, 1, 32]] = 3.0, 0.5, 2.0
    pieces[1, [0, 9, 32]] = 4.0, 0.5, 2.0
    return pieces.tobytes()


def line_bytes() -> bytes:
    """Return the same path compressed."""
    lines = [struct.pack("<BHh", 1, 2000, 4000), struct.pack("<BHh", 4, 2000, 1000)]
    return struct.pack("<4h", 3000, 0, 0, 0) + b"".join(lines) + bytes(3)


UPLOADS = {0: (line_pieces(), lib.CF_TRAJECTORY_TYPE_POLY4D, 2, 0), 1: (line_bytes(), COMPRESSED, 2, 1000)}

ticks = st.integers(1, 250)
places = st.floats(-2.0, 2.0, width=32)


def go_to(flight: Flight, x: float, y: float, yaw: float, duration: float) -> None:
    flight.call("go_to", [x, y, 1.0], yaw, duration, False, False)


@settings(max_examples=60)
@given(
    ticks,
    ticks,
    ticks,
    ticks,
    ticks,
    places,
    places,
    st.floats(-3.0, 3.0),
    st.floats(0.5, 4.0),
    st.sampled_from([0, 1]),
)
def test_setpoints_do_not_jump_from_takeoff_to_landing(
    rising: int, going: int, tracking: int, turning: int, returning: int, x: float, y: float, yaw: float, duration, id
) -> None:
    """Take-off, go-to, relative trajectory, spiral, go-to, landing, each begun at any time during the one before."""
    flight = Flight()
    flight.upload(id, *UPLOADS[id])
    flight.call("takeoff", 1.0, 2.0, 0.0, True)

    before = flight.run(rising)
    go_to(flight, x, y, yaw, duration)
    np.testing.assert_allclose(flight.sample(), before, atol=1e-6)

    before = flight.run(going)
    flight.call("start_trajectory", id, 1.0, True, False, False)
    position, velocity = flight.sample()
    np.testing.assert_allclose(position, before[0], atol=1e-6)
    np.testing.assert_allclose(velocity, [0.5, 0.0, 0.0], atol=1e-6)

    before = flight.run(tracking)
    flight.call("spiral", ffi.new("cf_spiral_t *", [False, True, 1.5, 0.8, 0.4, 0.3, 2.0]))
    position, velocity = flight.sample()
    np.testing.assert_allclose(position, before[0], atol=1e-6)
    assert velocity[2] == pytest.approx(0.15, abs=1e-6)

    before = flight.run(turning)
    go_to(flight, -x, -y, -yaw, duration)
    np.testing.assert_allclose(flight.sample(), before, atol=1e-6)

    before = flight.run(returning)
    flight.call("land", 0.0, 2.0, 0.0, True)
    position, velocity = flight.sample()
    np.testing.assert_allclose(position, before[0], atol=1e-6)
    assert velocity.tolist() == [0.0, 0.0, 0.0]

    # a landing lasts 200 ticks and then stops the motors
    flight.run(199)
    steps = np.diff(flight.path, axis=0)
    fastest = max(3.0, 12.0 * (math.hypot(x, y) + 2.0) / duration)
    assert np.linalg.norm(steps, axis=1).max() <= fastest * TICK


@given(st.floats(0.5, 4.0, width=32), st.floats(0.0, 1.25, width=32), st.booleans())
def test_timescale_stretches_time_and_nothing_else(timescale: float, place: float, reversed: bool) -> None:
    data, type, n_pieces, offset = UPLOADS[0]
    plain, slow = Flight(), Flight()
    for flight, scale in ((plain, 1.0), (slow, timescale)):
        flight.upload(0, data, type, n_pieces, offset)
        flight.call("start_trajectory", 0, scale, False, False, reversed)
        flight.now_us = round(4e6 * place * scale)
    (p, v), (p_slow, v_slow) = plain.sample(), slow.sample()
    np.testing.assert_allclose(p_slow, p, atol=1e-5)
    # at the corner a rounding decides which piece answers
    if abs(place - 0.5) > 1e-3 and abs(place - 1.0) > 1e-3:
        np.testing.assert_allclose(v_slow * timescale, v, atol=1e-5)


@given(st.integers(0, 500))
def test_compressed_and_uncompressed_lines_ask_for_the_same(tick: int) -> None:
    samples = []
    for id in UPLOADS:
        flight = Flight()
        flight.upload(id, *UPLOADS[id])
        flight.call("start_trajectory", id, 1.0, False, False, False)
        flight.now_us = 10_000 * tick
        samples.append(flight.sample())
    np.testing.assert_allclose(samples[0][0], samples[1][0], atol=1e-6)
    if tick not in (200, 400):  # joints belong to the earlier piece of one and to the later piece of the other
        np.testing.assert_allclose(samples[0][1], samples[1][1], atol=1e-6)


def test_go_to_leaves_a_trajectory_and_a_spiral_smoothly_after_an_hour() -> None:
    """A second in float32 has a resolution of 0.24 ms by then."""
    flight = Flight(now_us=3_600_000_000)
    flight.upload(1, *UPLOADS[1])
    flight.call("takeoff", 1.0, 2.0, 0.0, True)
    flight.run(250)
    for start in (
        lambda: flight.call("start_trajectory", 1, 1.0, True, False, False),
        lambda: flight.call("spiral", ffi.new("cf_spiral_t *", [True, False, 2.0, 1.0, 0.5, 0.5, 3.0])),
    ):
        start()
        before = flight.run(150)
        go_to(flight, 0.0, 0.0, 0.0, 3.0)
        np.testing.assert_allclose(flight.sample(), before, atol=1e-6)
        flight.run(320)
    assert flight.sample()[0] == pytest.approx([0.0, 0.0, 1.0], abs=1e-4)
