"""Upstream's form of our planner, with pointers, flies as that of a drone does, which has none."""

import math

from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw import cffirmware as firm
from crazychoir_fw._core import ffi, lib

number = st.floats(-3, 3, width=32)
duration = st.floats(0.125, 4, width=32)
point = st.tuples(number, number, number)
command = st.one_of(
    st.tuples(st.sampled_from(["takeoff", "land"]), number, number, duration),
    st.tuples(st.just("go_to"), st.booleans(), st.booleans(), point, number, duration),
    st.tuples(st.just("spiral"), st.booleans(), st.booleans(), number, number, number, number, duration),
    st.tuples(st.just("upload"), st.booleans(), st.booleans(), st.booleans(), number),
    st.tuples(st.sampled_from(["stop", "disable"])),
)


class Twins:
    """Both planners, told the same."""

    def __init__(self):
        self.ours = ffi.new("cf_planner_t *")
        lib.cf_planner_init(self.ours)
        self.memory = ffi.new("struct poly4d[]", 31)
        self.bytes = ffi.cast("uint8_t *", self.memory)
        self.theirs = firm.planner()
        firm.plan_init(self.theirs)
        self.trajectory = firm.piecewise_traj()
        self.trajectory.pieces = firm.poly4d_malloc(2)
        for i in range(2):
            piece = firm.piecewise_get(self.trajectory, i)
            piece.duration = self.memory[i].duration = 1.0
            for dim in range(4):
                for power in range(3):
                    value = 0.25 * (i + 1) + 0.5 * dim - 0.125 * power
                    firm.poly4d_set(piece, dim, power, value)
                    self.memory[i].p[dim][power] = value

    def start(self):
        return ffi.new("cf_plan_start_t *", {"pos": (1, 2, 0.5), "vel": (0, 0, 0), "yaw": 0.25})

    def do(self, words, t):
        """Return what both planners answer."""
        name, *values = words
        here, start = firm.mkvec(1, 2, 0.5), self.start()
        if name in ("takeoff", "land"):
            height, yaw, seconds = values
            plan = getattr(lib, f"cf_planner_{name}")
            return (
                plan(self.ours, start, height, yaw, seconds, t),
                getattr(firm, f"plan_{name}")(self.theirs, here, 0.25, height, yaw, seconds, t),
            )
        if name in ("stop", "disable"):
            getattr(lib, f"cf_planner_{name}")(self.ours)
            getattr(firm, f"plan_{name}")(self.theirs)
            return 0, 0
        return getattr(self, f"_{name}")(values, t, here, start)

    def _go_to(self, values, t, here, start):
        relative, linear, goal, yaw, seconds = values
        ours = lib.cf_planner_go_to(self.ours, self.bytes, start, relative, linear, goal, yaw, seconds, t)
        if firm.plan_is_stopped(self.theirs) or firm.plan_is_disabled(self.theirs):
            evaluation = firm.traj_eval_zero()
            evaluation.pos, evaluation.yaw = here, 0.25
            options = (evaluation, relative, linear, firm.mkvec(*goal), yaw, seconds, t)
            return ours, firm.plan_go_to_from(self.theirs, *options)
        return ours, firm.plan_go_to(self.theirs, relative, linear, firm.mkvec(*goal), yaw, seconds, t)

    def _spiral(self, values, t, here, start):
        names = ("sideways", "clockwise", "angle", "radius0", "radiusF", "ascent", "duration")
        spiral = ffi.new("cf_spiral_t *", dict(zip(names, values, strict=True)))
        evaluation = firm.traj_eval_zero()
        evaluation.pos, evaluation.yaw = here, 0.25
        return (
            lib.cf_planner_spiral(self.ours, start, spiral, t),
            firm.plan_spiral_from(self.theirs, evaluation, *values, t),
        )

    def _upload(self, values, t, here, start):
        backwards, relative, relative_yaw, pace = values
        uploaded = ffi.new(
            "cf_uploaded_trajectory_t *",
            {
                "n_pieces": 2,
                "timescale": 1 + abs(pace),
                "reversed": backwards,
                "relative_position": relative,
                "relative_yaw": relative_yaw,
            },
        )
        trajectory = self.trajectory
        trajectory.t_begin, trajectory.timescale, trajectory.n_pieces = t, 1 + abs(pace), 2
        return (
            lib.cf_planner_start_trajectory(self.ours, self.bytes, uploaded, start, t),
            firm.plan_start_trajectory(self.theirs, trajectory, backwards, relative, relative_yaw, here, 0.25),
        )

    def goals(self, t):
        """Return the bytes of both goals."""
        ours = lib.cf_planner_current_goal(self.ours, self.bytes, t)
        theirs = firm.plan_current_goal(self.theirs, t)
        return bytes(ffi.buffer(ffi.addressof(ours))), bytes(ffi.buffer(theirs.this))


@given(st.lists(st.tuples(command, st.floats(0.125, 3, width=32)), min_size=1, max_size=6))
def test_both_planners_agree_to_the_bit(commands):
    twins, t = Twins(), 0.0
    for words, later in commands:
        ours, theirs = twins.do(words, t)
        assert ours == theirs
        for share in (0, 0.5, 1):
            ours, theirs = twins.goals(t + share * later)
            assert ours == theirs
        t += later
        assert lib.cf_planner_state(twins.ours) == twins.theirs.state
        assert lib.cf_planner_is_finished(twins.ours, twins.bytes, t) == firm.plan_is_finished(twins.theirs, t)


def test_compressed_trajectory():
    """From (1, 0, 0) m in a straight line to (2, 0, 0) m within a second."""
    start = (1000).to_bytes(2, "little") + bytes(6)
    piece = bytes([0b01]) + (1000).to_bytes(2, "little") + (2000).to_bytes(2, "little")
    trajectory = firm.piecewise_traj_compressed()
    firm.piecewise_compressed_load(trajectory, start + piece)
    assert firm.piecewise_compressed_duration(trajectory) == 1
    planner = firm.planner()
    firm.plan_init(planner)
    firm.plan_start_compressed_trajectory(planner, trajectory, True, firm.mkvec(0, 5, 0))
    goal = firm.plan_current_goal(planner, 0.5)
    assert math.isclose(goal.pos.x, 0.5, abs_tol=1e-6)
    assert goal.pos.y == 5
    assert planner.type == firm.TRAJECTORY_TYPE_PIECEWISE_COMPRESSED
    assert firm.plan_is_finished(planner, 1.0)
