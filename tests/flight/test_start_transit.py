"""Drones that took off elsewhere go to above their starts, and keep apart."""

import numpy as np
import pytest
from flown_layers import SQUARE, formation, hover, mission, within

from crazychoir_fw.common.errors import StateError
from crazychoir_fw.flight.agents import starts_of
from crazychoir_fw.flight.engine import fly, make_experiment
from crazychoir_fw.flight.integrator_backend import IntegratorBackend
from crazychoir_fw.flight.start_transit import NEAR_M, StartTransit, plan_transit

FLIGHT = [{"takeoff": {"duration": 2}}, "go_to_start", {"land": {"duration": 2}}]


def elsewhere(flown, order):
    """Return a backend whose drones stand at the starts of others."""
    return IntegratorBackend(list("abcd")[: len(order)], starts_of(flown)[order])


def least_distance(log):
    at = log.stack("sim.x", "sim.y", "sim.z")
    gaps = np.linalg.norm(at[:, :, None] - at[:, None], axis=3)
    gaps[:, np.eye(at.shape[1], dtype=bool)] = np.inf
    return gaps.min()


@pytest.mark.parametrize("order", [[1, 2, 3, 0], [1, 0, 3, 2], [3, 2, 1, 0]])
def test_swapped_drones_end_above_their_starts_and_keep_apart(order):
    flown = mission(hover(4, flight=FLIGHT))
    result = fly(flown, backend=elsewhere(flown, order))
    assert result.log.stack("sim.x")[0] == pytest.approx(order, abs=1e-3)
    assert result.summary["failures"] == []
    assert least_distance(result.log) > 0.3
    end = np.column_stack([result.log.stack("sim.x")[-1], result.log.stack("sim.y")[-1]])
    np.testing.assert_allclose(end, starts_of(flown)[:, :2], atol=0.05)


def test_simulated_drones_come_back_from_each_others_starts():
    # without layers of planning: planners on board, over MuJoCo
    starts, height = [[0.0, 0.0], [0.7, 0.0], [0.7, 0.7], [0.0, 0.7]], 0.6
    swapped = [starts[1], starts[2], starts[3], starts[0]]
    data = within(within(hover(4), "layers.planning", None), "layers.control", None)
    data |= {
        "backend": "sim",
        "drones": [{"id": name, "position": at} for name, at in zip("abcd", starts, strict=True)],
        "flight": [
            {"takeoff": {"duration": 2}},
            {
                "together": [
                    {"go_to": {"drones": [name], "position": [*at, height], "duration": 3}}
                    for name, at in zip("abcd", swapped, strict=True)
                ]
            },
            "go_to_start",
            {"land": {"duration": 2}},
        ],
    }
    result = fly(mission(data))
    assert result.summary["failures"] == []
    assert least_distance(result.log) > 0.3
    name, begin, _ = result.log.metadata["windows"][5]
    assert name == "go_to_start"
    at = result.log.stack("sim.x", "sim.y")
    np.testing.assert_allclose(at[np.searchsorted(result.log.time, begin)], swapped, atol=0.1)
    np.testing.assert_allclose(at[-1], starts, atol=0.1)


@pytest.mark.parametrize("seed", range(20))
def test_plans_keep_apart_at_all_times(seed):
    """Any permutation of a grid, whose neighbors are 0.5 m apart, and drones that stay."""
    rng = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid([0.0, 0.5, 1.0], [0.0, 0.5, 1.0]), axis=-1).reshape(-1, 2)
    order = rng.permutation(9)
    starts = np.column_stack([grid, np.zeros(9)])
    at = np.column_stack([grid[order], rng.uniform(0.5, 1.0, 9)])
    at[:, :2] += rng.uniform(-0.03, 0.03, (9, 2))
    staying = [i for i in range(9) if order[i] == i]
    movers = [i for i in range(9) if i not in staying]
    here = at
    for stage in plan_transit(at, starts, movers, staying):
        there = here.copy()
        for i, goal in stage.goals.items():
            there[i] = goal
        for share in np.linspace(0.0, 1.0, 101):
            now = here + share * (there - here)
            gaps = np.linalg.norm(now[:, None] - now[None], axis=2) + 10.0 * np.eye(9)
            assert gaps.min() > NEAR_M
        here = there
    np.testing.assert_allclose(here[movers], np.column_stack([starts[movers, :2], at[movers, 2]]))


def hovering(order, **changes):
    flown = mission(hover(len(order), **changes))
    experiment = make_experiment(flown, elsewhere(flown, order))
    experiment.takeoff()
    experiment.run(3.0)
    return flown, experiment


def test_a_drone_that_stays_above_the_start_of_another_is_in_the_way():
    flown, experiment = hovering([1, 0])
    with pytest.raises(StateError, match="b stays above the start of a; send it as well"):
        StartTransit(experiment, flown, ["a"])
    assert StartTransit(experiment, flown).movers == [0, 1]


def test_a_sky_that_is_too_low_is_refused():
    area = {"low": [-2.0, -2.0, 0.0], "high": [2.0, 2.0, 1.0]}
    flown, experiment = hovering([1, 0], hardware={"safety_area": area})
    with pytest.raises(StateError, match=r"a drone would fly at 1\.1 m, allowed: 1 m, the safety area"):
        StartTransit(experiment, flown)


def test_a_drone_that_does_not_arrive_ends_it():
    flown, experiment = hovering([1, 0])
    transit = StartTransit(experiment, flown)
    transit.step(0.0)
    transit.step(1.0)
    assert not transit.is_over
    transit.step(60.0)
    assert transit.is_over
    assert transit.problems == ["GO TO STARTS ends: b does not arrive"]


@pytest.mark.parametrize(
    ("law", "backend"),
    [("BearingFormation", "integrator"), ("BearingFormation", "sim"), ("Containment", "integrator")],
)
def test_followers_of_a_formation_go_to_their_starts_and_into_it_again(law, backend):
    data = formation(backend=backend, seed=1)
    data["layers"]["guidance"] = {"class": law, "leaders": ["a", "b"], "height": 0.6}
    if law == "BearingFormation":
        data["layers"]["guidance"] |= {"formation": SQUARE, "gains": "mujoco"}
    data["flight"] = [
        {"takeoff": {"duration": 3}},
        {"start": {"duration": 5}},
        "go_to_start",
        {"start": {"duration": 5}},
        {"land": {"duration": 4}},
    ]
    flown = mission(data)
    result = fly(flown)
    assert [drone["phase"] for drone in result.summary["drones"]] == ["landed"] * 4, result.failures
    assert not [sentence for sentence in result.failures if "GO TO STARTS" in sentence]
    name, begin, end = result.log.metadata["windows"][2]
    assert name == "go_to_start"
    at = result.log.stack("sim.x", "sim.y")
    rows = np.searchsorted(result.log.time, [begin, end])
    starts = starts_of(flown)[:, :2]
    assert np.linalg.norm(at[rows[0]] - starts, axis=1).max() > 0.3  # the formation is elsewhere
    np.testing.assert_allclose(at[min(rows[1], len(at) - 1)], starts, atol=0.1)
    if law == "BearingFormation":  # containment lets both followers meet between two leaders
        assert least_distance(result.log) > 0.25
    # START brings them into the formation again
    again = np.searchsorted(result.log.time, result.log.metadata["windows"][3][2]) - 1
    assert np.linalg.norm(at[again] - starts, axis=1).max() > 0.3


def test_a_follower_can_be_sent_to_a_point():
    data = formation(
        flight=[{"takeoff": {"duration": 3}}, {"go_to": {"drones": ["c"], "position": [3, 3, 1], "duration": 4}}]
    )
    result = fly(mission(data))
    row = np.searchsorted(result.log.time, result.log.metadata["windows"][1][2])
    at = result.log.stack("sim.x", "sim.y", "sim.z")[min(row, len(result.log.time) - 1), 2]
    np.testing.assert_allclose(at, [3, 3, 1], atol=0.05)
