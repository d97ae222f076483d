"""The figure-8 of upstream's tests, flown from trajectory memory (docs/reference/control-pid.md#19, "figure-8")."""

from pathlib import Path

import numpy as np
import pytest
from test_acceptance import hovering, record, reference_world, within

DATA = Path(__file__).parents[1] / "bindings" / "builtin" / "planning" / "data" / "figure8.csv"


def pieces():
    """Return the ten pieces as (10, 33): duration, x and y are given; height and yaw are zero."""
    rows = np.loadtxt(DATA, delimiter=",", comments="#")
    table = np.zeros((len(rows), 33))
    table[:, 0:8], table[:, 8:16], table[:, 32] = rows[:, 1:9], rows[:, 9:17], rows[:, 0]
    return table


@pytest.mark.parametrize(("drag", "estimate_error_mm"), [("linear", 15.0), ("none", 2.0)])
def test_figure8_lags_as_the_stock_controller_does(drag, estimate_error_mm):
    """Half a second behind the reference, because positions have no velocity feed-forward: correct behavior."""
    world = reference_world(drag=drag)
    drone = hovering(world)
    duration = drone.high_level_commander.upload_trajectory(1, pieces())
    assert duration == pytest.approx(7.28)
    drone.high_level_commander.start_trajectory(1, relative_position=True)

    def sample():
        target = [drone.log[f"ctrltarget.{axis}"] for axis in "xyz"]
        return [*drone.true_position, *drone.estimated_position, *target]

    _, samples = record(world, duration, sample)
    truth, estimate, target = samples[:, 0:3], samples[:, 3:6], samples[:, 6:9]
    tracking = 1000 * np.sqrt(np.mean((truth - target) ** 2, axis=0))
    estimation = 1000 * np.sqrt(np.mean((estimate - truth) ** 2, axis=0))
    if drag == "linear":
        assert within(tracking[0], 330.0)
        assert within(tracking[1], 287.0)
    assert np.all(estimation[:2] < 1.3 * estimate_error_mm + 1.0)
    assert estimation[0] > 0.3 * estimate_error_mm
