"""The figures of summary.json on flights whose figures are known."""

import json
import stat
from types import SimpleNamespace

import numpy as np
import pytest

from crazychoir_fw.flight.plan_judge import flight_figures, hover_thrust, judge
from crazychoir_fw.flight.summary import Assessment, summarize, write_summary
from crazychoir_fw.mission import parse_mission
from crazychoir_fw.mission.plan import plan_flight

TOP_KEYS = [
    *("mission", "backend", "platform", "seed", "success", "failures", "sim_seconds", "wall_seconds"),
    *("real_time_factor", "criteria", "drones", "events", "collisions", "shares", "build", "expected_failures"),
    *("faults", "provider", "providers"),
]
DRONE_KEYS = [
    *("id", "rms_error_m", "max_error_m", "endpoint_error_m", "estimator_rms_m", "hover_thrust_percent"),
    *("provider", "battery_V", "supervisor_state"),
]
PID = [None, None]  # controllers that command counts


def ideal_flight(t):
    """Positions of the two drones of `hop`, which begins at t = 0: exactly as told."""
    height = float(np.interp(t, [0, 2, 5, 7], [0, 1, 1, 0]))
    return np.array([[0.0, 0.0, height], [1.0, 0.0, height]])


@pytest.fixture
def mission(hop):
    return parse_mission(hop)


@pytest.fixture
def plan(mission):
    return plan_flight(mission)


@pytest.fixture
def backend():
    """What remains of simulated drones after a flight."""
    drones = [
        SimpleNamespace(
            id=drone_id,
            config=SimpleNamespace(provider="builtin", controller=None),
            battery_voltage=3.91234,
            supervisor_state="Landed",
        )
        for drone_id in ("cf1", "cf2")
    ]
    world = SimpleNamespace(time=10.0, drones=drones, events=[])
    return SimpleNamespace(world=world, faults=[])


def summary_of(mission, backend, log, flown=10.0, wall=0.5, failures=()):
    figures = flight_figures(plan_flight(mission), log, 0.0, PID)
    return summarize(mission, backend, log, Assessment(figures, list(failures), [], {"record": 0.5}), flown, wall)


def test_summary_has_the_agreed_keys_in_order(mission, backend, make_log):
    summary = summary_of(mission, backend, make_log(ideal_flight, 9.0))
    assert list(summary) == TOP_KEYS
    assert [list(drone) for drone in summary["drones"]] == [DRONE_KEYS] * 2
    assert summary["mission"] == "hop"
    assert (summary["provider"], summary["platform"], summary["backend"]) == ("builtin", "cf2", "sim")
    assert summary["real_time_factor"] == 20.0
    assert summary["drones"][1]["battery_V"] == 3.9123
    assert json.loads(json.dumps(summary, allow_nan=False)) == summary


def test_drones_without_a_world_have_no_onboard_software(mission, backend, make_log):
    del backend.world
    summary = summary_of(mission, backend, make_log(ideal_flight, 9.0))
    assert set(TOP_KEYS) - set(summary) == {"provider", "providers"}
    assert set(DRONE_KEYS) - set(summary["drones"][0]) == {"provider", "battery_V", "supervisor_state"}


def test_summary_names_all_platforms_of_a_mixed_fleet(hop, backend, make_log):
    hop["drones"][1]["platform"] = "cf21bl"
    summary = summary_of(parse_mission(hop), backend, make_log(ideal_flight, 9.0), failures=["cf1: crashed"])
    assert summary["platform"] == "cf2, cf21bl"
    assert not summary["success"]


def test_constant_errors_come_out_as_they_went_in(plan, make_log):
    log = make_log(ideal_flight, 9.0, estimate_error=0.02, tracking_error=0.05)
    drone = flight_figures(plan, log, 0.0, PID)[0]
    assert drone["rms_error_m"] == drone["max_error_m"] == 0.05
    assert drone["estimator_rms_m"] == 0.02
    assert drone["endpoint_error_m"] == 0.0
    assert drone["hover_thrust_percent"] == pytest.approx(100 * 39000 / 65535, abs=0.01)


@pytest.mark.parametrize("controller", ["brescianini", "lee", "out_of_tree"])
def test_controller_that_commands_newtons_has_no_thrust_figure(plan, make_log, controller):
    first, second = flight_figures(plan, make_log(ideal_flight, 9.0), 0.0, [None, controller])
    assert first["hover_thrust_percent"] is not None
    assert second["hover_thrust_percent"] is None


def test_setpoint_that_vanishes_after_landing_is_no_tracking_error(plan, make_log):
    log = make_log(ideal_flight, 9.0)
    # the planner has stopped and the set-point is null, while the supervisor still says flying
    for name in ("ctrltarget.x", "ctrltarget.z"):
        log.signals[name][log.time >= 7.0] = 0.0
    log.signals["ctrltarget.x"][log.time <= 0.0] = 0.0
    assert flight_figures(plan, log, 0.0, PID)[1]["max_error_m"] == 0.0


def test_errors_on_the_floor_do_not_count(plan, make_log):
    log = make_log(ideal_flight, 9.0, tracking_error=0.3, landed_after=-1.0)
    drone = flight_figures(plan, log, 0.0, PID)[0]
    assert drone["rms_error_m"] is drone["max_error_m"] is drone["hover_thrust_percent"] is None


def test_plan_may_begin_late_in_the_log(mission, plan, make_log):
    log = make_log(lambda t: ideal_flight(t - 3.0), 12.0, tracking_error=0.05)
    assert judge(mission, plan, log, start=3.0) == []
    assert any("missed" in failure for failure in judge(mission, plan, log, start=0.0))


def test_flight_as_told_has_no_failures(mission, plan, make_log):
    assert judge(mission, plan, make_log(ideal_flight, 9.0), 0.0) == []


def test_drone_that_stays_on_the_floor_misses_its_takeoff(mission, plan, make_log):
    def second_stays(t):
        return ideal_flight(t) * [[1, 1, 1], [1, 1, 0]]

    failures = judge(mission, plan, make_log(second_stays, 9.0), 0.0)
    assert failures[0] == "cf2: missed the target of flight[0].takeoff by 1.00 m, tolerance 0.2 m"
    assert all(failure.startswith("cf2") for failure in failures)


def test_drone_that_lands_elsewhere_misses_its_endpoint(mission, plan, make_log):
    def first_drifts_while_landing(t):
        return ideal_flight(t) + np.array([[0.2 * (t > 5.6), 0, 0], [0, 0, 0]])

    failures = judge(mission, plan, make_log(first_drifts_while_landing, 9.0), 0.0)
    assert failures == ["cf1: ended 0.20 m from its target, tolerance 0.1 m"]


def test_endpoint_of_a_landed_drone_is_its_own_floor(mission, plan, make_log):
    log = make_log(lambda t: ideal_flight(t) + np.array([0, 0, 0.0145]), 9.0)
    assert judge(mission, plan, log, 0.0) == []


def test_waypoint_is_reached_when_the_drone_comes_by_late(hop, make_log):
    hop["flight"] = ["takeoff", {"go_to": {"offset": [1, 0, 0], "duration": 2}}, {"hover": {"duration": 3}}]
    mission = parse_mission(hop)
    plan = plan_flight(mission)

    def late(seconds):
        def path(t):
            x = float(np.interp(t - seconds, [2, 4], [0, 1]))
            return np.array([[x, 0, min(0.5, t)], [1 + x, 0, min(0.5, t)]])

        return path

    assert judge(mission, plan, make_log(late(0.5), 9.0), 0.0) == []
    failures = judge(mission, plan, make_log(late(2.0), 9.0), 0.0)
    assert [failure.split(" by ")[0] for failure in failures] == [
        "cf1: missed the target of flight[1].go_to",
        "cf2: missed the target of flight[1].go_to",
    ]


def test_flight_of_a_single_sample_has_null_figures(mission, backend, make_log):
    summary = summary_of(mission, backend, make_log(ideal_flight, 0.0), 0.0, 0.0, ["cf1: is not ready to fly"])
    assert summary["real_time_factor"] is None
    assert summary["drones"][0]["rms_error_m"] is None
    assert json.dumps(summary, allow_nan=False)


def test_hover_thrust_is_taken_where_the_drone_is_steadiest():
    time = np.arange(0.0, 10.0, 0.01)
    still = (time > 5.5) & (time < 7.5)
    position = np.stack([np.where(still, 5.5, time), 0 * time, 0 * time], axis=1)
    thrust = np.where(still, 30000.0, 50000.0)
    assert hover_thrust(time, position, thrust, time > 1) == 30000.0
    # in the part before, all seconds are alike
    assert hover_thrust(time, position, thrust, time < 5) == 50000.0


def test_summary_file_is_whole_and_readable_by_everybody(tmp_path):
    path = tmp_path / "summary.json"
    path.write_text("old")
    write_summary(path, {"drones": [1, None]})
    assert json.loads(path.read_text()) == {"drones": [1, None]}
    assert stat.S_IMODE(path.stat().st_mode) == 0o644
    assert list(tmp_path.iterdir()) == [path]


def test_summary_that_cannot_be_written_leaves_the_old_one(tmp_path):
    path = tmp_path / "summary.json"
    path.write_text("old")
    with pytest.raises(ValueError, match="not JSON compliant"):
        write_summary(path, {"rms": float("nan")})
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]
