"""The estimator task around a provider (docs/reference/estimators.md#8, #9, #14, #17.M and #18)."""

import math

import numpy as np
import pytest

from crazychoir_fw._core import ffi, lib

F = np.float32


class Provider:
    """A provider whose filter is that of the builtin one; `calls` tells the names of what was called."""

    def __init__(self) -> None:
        self.kalman = ffi.new("cf_kalman_t *")
        lib.cf_kalman_boot(self.kalman, 0)
        self.state = ffi.cast("void *", self.kalman)
        self.calls: list[str] = []
        self.predictions: list[tuple[list[float], list[float], bool]] = []
        self.gyro_of_updates: list[float] = []
        self._functions = [
            self._function(name)
            for name in (
                "init",
                "predict",
                "add_process_noise",
                "update",
                "finalize",
                "is_within_bounds",
                "externalize",
            )
        ]
        self._functions += self._complementary()
        self.table = ffi.new("cf_provider_t *", dict(self._functions))

    def _complementary(self) -> list[tuple[str, ffi.CData]]:
        """A complementary estimator that tells what it was given: the step as x, the tick as y."""
        kinds = dict(ffi.typeof("cf_provider_t").fields)
        self.latest = ffi.new("cf_latest_samples_t *")

        def init(state: ffi.CData) -> None:
            self.calls.append("complementary_init")

        def update(state: ffi.CData, latest: ffi.CData, estimate: ffi.CData, step: int, now_ms: int) -> None:
            self.calls.append("complementary")
            self.latest[0] = latest[0]
            estimate.position.x = step
            estimate.position.y = now_ms

        return [
            ("complementary_init", ffi.callback(kinds["complementary_init"].type, init)),
            ("complementary", ffi.callback(kinds["complementary"].type, update)),
        ]

    def _function(self, name: str) -> tuple[str, ffi.CData]:
        entry = f"kalman_{name}"
        kind = dict(ffi.typeof("cf_provider_t").fields)[entry].type
        function = getattr(lib, f"cf_kalman_{name}")

        def call(state: ffi.CData, *arguments: object) -> object:
            self.calls.append(name)
            if name == "predict":
                acc, gyro, _, is_flying = arguments
                self.predictions.append((list(acc.axis), list(gyro.axis), is_flying))
            if name == "update":
                self.gyro_of_updates.append(arguments[1].x)
            return function(ffi.cast("cf_kalman_t *", state), *arguments)

        return entry, ffi.callback(kind, call)


@pytest.fixture
def provider():
    return Provider()


class Task:
    """An estimator with its provider, started at a tick."""

    def __init__(self, provider: Provider, now_ms: int) -> None:
        self.provider = provider
        self.now_ms = now_ms
        self.estimator = ffi.new("cf_estimator_t *")
        ffi.buffer(self.estimator)[:] = b"\xaa" * ffi.sizeof("cf_estimator_t")
        lib.cf_estimator_init(self.estimator, provider.table, provider.state, lib.StateEstimatorTypeKalman, now_ms)

    def enqueue(self, kind: int, **data: dict) -> bool:
        return lib.cf_estimator_enqueue(self.estimator, ffi.new("measurement_t *", {"type": kind, "data": data}))

    def gyro(self, x: float, y: float, z: float) -> bool:
        return self.enqueue(lib.MeasurementTypeGyroscope, gyroscope={"gyro": {"x": x, "y": y, "z": z}})

    def acc(self, x: float, y: float, z: float) -> bool:
        return self.enqueue(lib.MeasurementTypeAcceleration, acceleration={"acc": {"x": x, "y": y, "z": z}})

    def switch_to(self, kind: int) -> bool:
        return lib.cf_estimator_switch_to(self.estimator, self.provider.table, self.provider.state, kind, self.now_ms)

    def update(self, step: int = 1) -> ffi.CData:
        """Return the estimate that the stabilizer gets at the next tick."""
        state = ffi.new("state_t *", {"velocity": {"x": 7.0}})
        lib.cf_estimator_update(self.estimator, self.provider.table, self.provider.state, state, step, self.now_ms + 1)
        return state

    def run(self, is_flying: bool = False) -> ffi.CData:
        """Run the loop of the next tick and return the estimate."""
        self.now_ms += 1
        lib.cf_estimator_run(self.estimator, self.provider.table, self.provider.state, self.now_ms, is_flying)
        state = ffi.new("state_t *")
        lib.cf_estimator_get(self.estimator, state)
        return state


@pytest.fixture
def task(provider):
    return Task(provider, 1000)


# docs/reference/estimators.md#17.M: tick, position, velocity, roll pitch yaw (deg), P_X, P_PZ, P_D2
TIMING = [
    (1001, (0, 0, -4.90500088e-6), (0, 0, -0.00980998203), (0, 0, 0), (100, 1.00999998e-4, 1.00009995e-4)),
    (1002, (0, 0, -4.90500088e-6), (0, 0, -0.00980998203), (0, 0, 0), (100, 1.01999998e-4, 1.00019992e-4)),
    (
        1010,
        (0.0999998972, 0.199999794, 0.299970001),
        (8.00989801e-6, -1.29427644e-5, -0.00981673133),
        (0.874294281, 1.94652462, 4.7583828),
        (9.99998956e-5, 1.10000001e-4, 1.68427505e-5),
    ),
    (
        1011,
        (0.100009084, 0.199983001, 0.299877077),
        (0.00183262187, -0.00334563036, -0.00876958016),
        (0.920731544, 1.97575927, 4.83312607),
        (1.00010147e-4, 1.11000336e-4, 1.68527476e-5),
    ),
    (
        1020,
        (0.100004539, 0.199991509, 0.29993856),
        (0.00157732284, -0.00344943232, -0.00876974035),
        (0.97144866, 2.14436483, 5.23368835),
        (5.00025344e-5, 1.19994191e-4, 9.22466734e-6),
    ),
    (
        1100,
        (0.100351281, 0.199089035, 0.299833298),
        (0.0116855409, -0.0320213027, -3.34902899e-4),
        (1.21408856, 2.4307251, 5.93199444),
        (1.02275017e-5, 1.98153561e-4, 2.26553607e-6),
    ),
    (
        1101,
        (0.100448325, 0.198756218, 0.299834281),
        (0.00772696594, -0.0345500112, 5.30887104e-4),
        (1.26069784, 2.46244431, 6.01139879),
        (1.03442972e-5, 1.99153947e-4, 2.27553573e-6),
    ),
    (
        1200,
        (0.0995300785, 0.196709201, 0.300245762),
        (-0.0268960111, -0.0516268201, 0.00835932046),
        (1.40272045, 2.58420324, 6.31102276),
        (6.06797539e-6, 2.75774568e-4, 1.55083455e-6),
    ),
    (
        1300,
        (0.0964435115, 0.194085315, 0.300986648),
        (-0.0622405484, -0.065995425, 0.0151191475),
        (1.52117896, 2.6744442, 6.53664017),
        # the reference prints 5.65544456e-6 for P_X; this filter and the dense twin of it both get 5.65554456e-6
        (5.65554456e-6, 3.02607892e-4, 1.41536452e-6),
    ),
]


@pytest.fixture(scope="module")
def timing_flight() -> dict[int, tuple[list[float], ...]]:
    """Return position, velocity, attitude and variances by tick for the flight of vector M."""
    task = Task(Provider(), 1000)
    pose = {
        "pos": [0.1, 0.2, 0.3],
        "quat": {"x": 0.01, "y": -0.02, "z": 0.05, "w": 0.9985},
        "stdDevPos": 0.01,
        "stdDevQuat": 4.5e-3,
    }
    seen = {}
    for tick in range(1001, 1301):
        task.gyro(5.0, -3.0, 8.0)
        task.acc(0.05, -0.02, 1.01)
        if tick % 10 == 0:
            task.enqueue(lib.MeasurementTypePose, pose=pose)
        state = task.run(is_flying=tick > 1100)
        assert task.now_ms == tick
        P = task.provider.kalman.core.P
        seen[tick] = (
            [state.position.x, state.position.y, state.position.z],
            [state.velocity.x, state.velocity.y, state.velocity.z],
            [state.attitude.roll, state.attitude.pitch, state.attitude.yaw],
            [P[0][0], P[5][5], P[8][8]],
        )
    return seen


@pytest.mark.parametrize(("tick", "position", "velocity", "attitude", "variances"), TIMING)
def test_check_vector_m(timing_flight, tick, position, velocity, attitude, variances):
    seen = timing_flight[tick]
    np.testing.assert_allclose(seen[0], position, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(seen[1], velocity, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(seen[2], attitude, rtol=1e-6, atol=1e-12)
    np.testing.assert_allclose(seen[3], variances, rtol=1e-6)


def test_one_loop_calls_the_filter_in_order(task):
    task.provider.calls.clear()
    task.gyro(0, 0, 0)
    task.enqueue(lib.MeasurementTypePosition, position={"pos": [0, 0, 0], "stdDev": 0.01})
    task.enqueue(lib.MeasurementTypeTOF, tof={"distance": 0.5, "stdDev": 0.01})
    task.run()
    expected = ["predict", "add_process_noise", "update", "update", "finalize", "is_within_bounds", "externalize"]
    assert task.provider.calls == expected


def test_predictions_come_at_once_and_then_every_ten_loops(task):
    ticks = []
    for _ in range(50):
        before = len(task.provider.predictions)
        task.run()
        if len(task.provider.predictions) > before:
            ticks.append(task.now_ms)
    assert ticks == [1001, 1011, 1021, 1031, 1041]


def test_predictions_average_the_samples_of_earlier_loops(task):
    for i in range(11):
        task.gyro(i, 2.0 * i, -i)
        task.acc(0.0, 0.1 * i, 1.0)
        task.run(is_flying=i > 5)
    first, second = task.provider.predictions
    assert first == ([0.0, 0.0, 0.0], [0.0, 0.0, 0.0], False)
    # the samples 0 to 9: the eleventh is drained after the prediction
    acc, gyro, is_flying = second
    np.testing.assert_allclose(acc, [0.0, 0.45 * 9.81, 9.81], rtol=1e-6)
    np.testing.assert_allclose(gyro, np.radians([4.5, 9.0, -4.5]), rtol=1e-6)
    assert is_flying


def test_flow_sees_the_gyroscope_sample_before_it(task):
    flow = {"dpixelx": 1.0, "dpixely": 1.0, "stdDevX": 2.0, "stdDevY": 2.0, "dt": 0.01}
    task.gyro(1.0, 0, 0)
    task.enqueue(lib.MeasurementTypeFlow, flow=flow)
    task.gyro(2.0, 0, 0)
    task.enqueue(lib.MeasurementTypeFlow, flow=flow)
    task.run()
    assert task.provider.gyro_of_updates == [1.0, 2.0]


def test_queue_keeps_the_oldest_twenty(task):
    assert [task.gyro(float(i), 0, 0) for i in range(25)] == [True] * 20 + [False] * 5
    assert task.estimator.rejected == 5
    task.run()
    assert task.estimator.gyroLatest.x == 19.0
    assert task.estimator.queue_count == 0
    # the ring goes on behind its end
    assert [task.gyro(float(i), 0, 0) for i in range(20, 30)] == [True] * 10
    task.run()
    assert task.estimator.gyroLatest.x == 29.0
    assert task.estimator.gyroSubSampler.count == 30


def test_estimate_is_zero_before_the_first_loop(task):
    state = ffi.new("state_t *")
    lib.cf_estimator_get(task.estimator, state)
    assert ffi.buffer(state)[:] == bytes(ffi.sizeof("state_t"))


def test_acceleration_of_the_estimate_is_the_newest_sample_every_loop(task):
    for i in range(5):
        task.acc(0.0, 0.0, 1.0 + 0.01 * i)
        state = task.run()
        assert state.acc.z == pytest.approx(0.01 * i, abs=1e-5)


def test_reset_parameter_restarts_the_filter_and_clears_itself(task):
    for _ in range(5):
        task.gyro(10.0, 0, 0)
        task.run()
    task.provider.kalman.core.S[0] = 3.0
    task.estimator.resetEstimation = 1
    task.provider.calls.clear()
    task.run()
    assert task.provider.calls[0] == "init"
    assert "predict" not in task.provider.calls  # the next prediction stays where it was
    assert task.estimator.resetEstimation == 0
    assert task.provider.kalman.core.S[0] == 0.0
    assert task.estimator.gyroSubSampler.count == 0
    assert task.estimator.gyroLatest.x == 10.0


def test_state_out_of_bounds_restarts_the_filter_in_the_next_loop(task):
    task.run()
    task.provider.kalman.core.S[4] = 11.0
    task.run()
    assert task.estimator.resetEstimation == 1
    task.provider.calls.clear()
    task.run()
    assert task.provider.calls[0] == "init"
    assert task.estimator.resetEstimation == 0


def test_a_filter_booted_long_before_its_first_loop_falls_and_restarts_once(provider):
    """docs/reference/estimators.md#18.1: started at tick 0, first loop at 1513."""
    task = Task(provider, 0)
    task.now_ms = 1512
    task.run()
    assert provider.kalman.core.S[2] == pytest.approx(-11.23, abs=0.005)
    assert provider.kalman.core.S[5] == pytest.approx(-14.84, abs=0.005)
    for _ in range(1000):
        task.gyro(0, 0, 0)
        task.acc(0, 0, 1.0)
        task.run()
    assert provider.calls.count("init") == 2
    assert abs(provider.kalman.core.S[5]) < 0.2


def test_rates_are_counted_over_a_second(task):
    for i in range(1500):
        task.gyro(0, 0, 0)
        task.acc(0, 0, 1.0)
        if i == 10:
            for _ in range(20):
                task.gyro(0, 0, 0)
        task.run()
    rates = list(task.estimator.rates)
    assert rates[lib.CF_ESTIMATOR_UPDATED] == 1000.0
    assert rates[lib.CF_ESTIMATOR_PREDICTED] == 100.0
    assert rates[lib.CF_ESTIMATOR_FINALIZED] == 100.0
    assert rates[lib.CF_ESTIMATOR_APPENDED] == 2020.0
    assert rates[lib.CF_ESTIMATOR_REJECTED] == 2.0


def test_lost_measurements_reach_the_estimate_where_they_can_be_seen(task):
    task.run()
    task.enqueue(lib.MeasurementTypePosition, position={"pos": [math.nan, 0, 0], "stdDev": 0.01})
    state = task.run()
    assert math.isnan(state.position.x)
    assert all(math.isfinite(x) for row in task.provider.kalman.core.P for x in row)


def names(table: ffi.CData) -> list[str]:
    found = [table.rows[i] for i in range(table.count)]
    return [f"{ffi.string(row.group).decode()}.{ffi.string(row.name).decode()}" for row in found]


def test_variables_have_the_names_of_the_firmware():
    assert names(lib.cf_estimator_parameters()) == ["kalman.resetEstimation"]
    assert names(lib.cf_estimator_logs()) == [
        *("kalman.rtUpdate", "kalman.rtPred", "kalman.rtFinal"),
        *("estimator.rtApnd", "estimator.rtRej"),
    ]


def test_selection_numbers_are_those_of_the_firmware():
    selection = (
        lib.StateEstimatorTypeAutoSelect,
        lib.StateEstimatorTypeComplementary,
        lib.StateEstimatorTypeKalman,
        lib.StateEstimatorTypeOutOfTree,
        lib.StateEstimatorType_COUNT,
    )
    assert selection == (0, 1, 2, 3, 4)


AUTO, COMPLEMENTARY, KALMAN, OUT_OF_TREE = 0, 1, 2, 3


@pytest.mark.parametrize(("kind", "active"), [(AUTO, COMPLEMENTARY), (COMPLEMENTARY, COMPLEMENTARY), (KALMAN, KALMAN)])
def test_selection_starts_an_estimator_and_auto_is_complementary(task, kind, active):
    task.provider.calls.clear()
    assert task.switch_to(kind)
    assert task.estimator.type == active
    assert task.provider.calls == ["init" if active == KALMAN else "complementary_init"]


@pytest.mark.parametrize("kind", [-1, OUT_OF_TREE, 4, 255])
def test_selection_of_what_does_not_exist_changes_nothing(task, kind):
    task.provider.calls.clear()
    assert not task.switch_to(kind)
    assert task.estimator.type == KALMAN
    assert task.provider.calls == []


def test_estimators_have_the_names_of_the_firmware():
    names = [ffi.string(lib.cf_estimator_name(kind)).decode() for kind in range(4)]
    assert names == ["None", "Complementary", "Kalman", "OutOfTree"]
    assert [lib.cf_estimator_name(kind) for kind in (-1, 4)] == [ffi.NULL, ffi.NULL]


@pytest.fixture
def own(task):
    """A task whose provider carries a user's own estimator; `seen` tells the types of the measurements it got."""
    kinds = dict(ffi.typeof("cf_provider_t").fields)
    seen: list[list[int]] = []
    sweeps: list[bool] = []

    @ffi.callback(kinds["out_of_tree_estimator_init"].type)
    def init(state):
        task.provider.calls.append("out_of_tree_init")

    @ffi.callback(kinds["out_of_tree_estimator"].type)
    def update(state, queue, count, estimate, step, now_ms):
        seen.append([queue[i].type for i in range(count)])
        sweeps.extend(
            queue[i].data.sweepAngle.rotorPos != ffi.NULL
            for i in range(count)
            if queue[i].type == lib.MeasurementTypeSweepAngle
        )
        estimate.position.x, estimate.position.y = step, now_ms

    task.provider.table.out_of_tree_estimator_init = init
    task.provider.table.out_of_tree_estimator = update
    task.provider.calls.clear()
    task.functions, task.seen, task.sweeps = (init, update), seen, sweeps
    assert task.switch_to(OUT_OF_TREE)
    return task


def test_users_own_estimator_takes_the_whole_queue_in_every_step(own):
    assert own.provider.calls == ["out_of_tree_init"]
    assert own.estimator.type == OUT_OF_TREE
    estimate = ffi.new("state_t *", {"velocity": {"x": 4.0}})
    for kind in (lib.MeasurementTypeGyroscope, lib.MeasurementTypePose, lib.MeasurementTypeFlow):
        lib.cf_estimator_enqueue(own.estimator, ffi.new("measurement_t *", {"type": kind}))
    arguments = (own.estimator, own.provider.table, own.provider.state, estimate)
    lib.cf_estimator_update(*arguments, 12, 3000)
    lib.cf_estimator_update(*arguments, 13, 3001)
    assert own.seen == [[lib.MeasurementTypeGyroscope, lib.MeasurementTypePose, lib.MeasurementTypeFlow], []]
    # what it does not write stays
    assert (estimate.position.x, estimate.position.y, estimate.velocity.x) == (13.0, 3001.0, 4.0)
    assert own.estimator.queue_count == 0
    # the task of the Kalman filter stands still
    own.provider.calls.clear()
    lib.cf_estimator_run(own.estimator, own.provider.table, own.provider.state, 3002, True)
    assert own.provider.calls == []


def test_users_own_estimator_gets_sweeps_with_their_base_station(own):
    sweep = ffi.new("measurement_t *", {"type": lib.MeasurementTypeSweepAngle})
    for station in (0, 99):
        sweep.data.sweepAngle.baseStationId = station
        lib.cf_estimator_enqueue(own.estimator, sweep)
    lib.cf_estimator_update(own.estimator, own.provider.table, own.provider.state, ffi.new("state_t *"), 1, 1)
    assert own.sweeps == [True, False]
    assert own.estimator.queue[0].data.sweepAngle.rotorPos == ffi.NULL


@pytest.mark.parametrize("other", [COMPLEMENTARY, KALMAN])
def test_another_estimator_takes_over_from_the_users_own(own, other):
    assert own.switch_to(other)
    assert own.estimator.type == other


def test_complementary_estimator_gets_the_latest_of_each_sensor(task):
    task.switch_to(COMPLEMENTARY)
    for i in range(1, 4):
        task.gyro(i, 0, 0)
        task.acc(0, i, 0)
    task.enqueue(lib.MeasurementTypeBarometer, barometer={"baro": {"asl": 5.0}})
    task.enqueue(lib.MeasurementTypeTOF, tof={"distance": 0.5, "timestamp": 990})
    task.enqueue(lib.MeasurementTypeTOF, tof={"distance": 0.6, "timestamp": 1000})
    task.enqueue(lib.MeasurementTypePose, pose={"pos": [9.0, 9.0, 9.0]})
    state = task.update(step=33)
    latest = task.provider.latest
    assert (latest.gyro.x, latest.acc.y, latest.baro.asl) == (3.0, 3.0, 5.0)
    assert latest.tof.distance == pytest.approx(0.6)
    assert latest.tof.timestamp == 1000
    assert task.estimator.queue_count == 0
    assert (state.position.x, state.position.y) == (33.0, 1001.0)
    assert state.velocity.x == 7.0  # members that no measurement writes stay

    # nothing new: the same again
    task.update(step=34)
    assert task.provider.latest.gyro.x == 3.0


def test_task_of_the_kalman_filter_stands_still_while_the_other_flies(task):
    task.switch_to(COMPLEMENTARY)
    task.provider.calls.clear()
    for step in range(1, 1501):
        task.gyro(0, 0, 0)
        task.update(step)
        task.run()
    assert set(task.provider.calls) == {"complementary"}
    rates = list(task.estimator.rates)
    assert rates[lib.CF_ESTIMATOR_UPDATED] == 0.0
    assert rates[lib.CF_ESTIMATOR_APPENDED] == 1000.0
    assert rates[lib.CF_ESTIMATOR_REJECTED] == 0.0


def test_kalman_filter_starts_anew_when_it_is_selected_again(task):
    """docs/reference/estimators.md#8.1 and #18.1: the first loop predicts over no time, with averages of nothing."""
    task.gyro(30.0, 0, 0)
    task.run()
    task.provider.kalman.core.S[0] = 3.0
    before = task.run()
    task.switch_to(COMPLEMENTARY)
    task.now_ms += 5000
    task.switch_to(KALMAN)
    assert task.provider.kalman.core.S[0] == 0.0
    assert task.estimator.gyroSubSampler.count == 0

    # the stabilizer still gets the estimate of the latest loop, 5 s old
    assert task.update().position.x == before.position.x == 3.0
    task.provider.predictions.clear()
    state = task.run()
    acc, gyro, _ = task.provider.predictions[0]
    assert (acc, gyro) == ([0.0] * 3, [0.0] * 3)
    assert state.position.z == pytest.approx(0.0, abs=1e-5)


def test_reset_is_kept_for_the_kalman_filter(task):
    task.switch_to(COMPLEMENTARY)
    task.estimator.resetEstimation = 1
    task.run()
    assert task.estimator.resetEstimation == 1
    task.switch_to(KALMAN)
    task.run()
    assert task.estimator.resetEstimation == 0
