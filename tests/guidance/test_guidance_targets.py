"""Target lists and the double integrator of ChoiRbot."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.guidance import Phase, SimpleDIControl, TargetListGuidance


def fly(guidance, seconds, position, velocity=None, dt=0.05, now=0.0):
    """Fly a drone that is where its reference is, or a double integrator."""
    velocity = np.zeros(3) if velocity is None else velocity
    for k in range(round(seconds / dt)):
        guidance.set_pose(Pose(position=position.copy(), velocity=velocity.copy()))
        reference = guidance.step(now + k * dt).reference
        if reference is not None and guidance.kind == "acceleration":
            velocity += dt * reference.acceleration
            position += dt * velocity
        elif reference is not None:
            position[:] = reference.position
    return now + seconds


def test_targets_are_reached_one_after_the_other():
    guidance = TargetListGuidance(2.0, [(1.0, 0.0, 1.0), (1.0, 1.0, 0.5)], speed=0.5)
    position = np.zeros(3)
    guidance.set_pose(Pose(position=position.copy()))
    guidance.takeoff(0.0)
    now = fly(guidance, 3.0, position)
    np.testing.assert_allclose(position, (0.0, 0.0, 1.0))
    guidance.start(now)
    now = fly(guidance, 1.9, position, now=now)
    assert guidance._next == 0
    now = fly(guidance, 3.0, position, now=now)
    np.testing.assert_allclose(position, (1.0, 1.0, 0.5), atol=0.05)
    assert guidance.is_done
    guidance.land(now)
    fly(guidance, 5.0, position, now=now)
    assert position[2] < 0.02
    assert guidance.phase is Phase.IDLE


def test_double_integrator_goes_to_its_goal_as_its_poles_say():
    guidance = SimpleDIControl(goal=(1.0, 0.0, 1.0))
    position, velocity = np.array([0.0, 0.0, 1.0]), np.zeros(3)
    guidance.set_pose(Pose(position=position.copy(), velocity=velocity.copy()))
    guidance.start(0.0)
    fly(guidance, 10.0, position, velocity, dt=0.01)
    slow, fast = np.sort(np.abs(np.roots([1.0, 5.0, 1.0])))
    left = (fast * np.exp(-slow * 10.0) - slow * np.exp(-fast * 10.0)) / (fast - slow)
    np.testing.assert_allclose(position, (1.0 - left, 0.0, 1.0), atol=2e-3)


def test_double_integrator_takes_off_and_lands():
    guidance = SimpleDIControl(2.0, height=0.8)
    position, velocity = np.zeros(3), np.zeros(3)
    guidance.set_pose(Pose(position=position.copy(), velocity=velocity.copy()))
    guidance.takeoff(0.0)
    now = fly(guidance, 12.0, position, velocity, dt=0.02)
    np.testing.assert_allclose(position, (0.0, 0.0, 0.8), atol=0.01)
    guidance.land(now)
    fly(guidance, 8.0, position, velocity, dt=0.02, now=now)
    assert guidance.phase is Phase.IDLE
    assert position[2] < 0.1


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: TargetListGuidance(goals=[(1.0, 2.0)]), "goals have shape"),
        (lambda: TargetListGuidance(speed=0.0), "speed is 0.0"),
        (lambda: TargetListGuidance(tolerance=-1.0), "tolerance is -1.0"),
        (lambda: SimpleDIControl(k_p=0.0), "k_p is 0.0"),
        (lambda: SimpleDIControl(goal=(1.0, np.nan, 1.0)), "goal"),
    ],
)
def test_bad_values_are_refused(make, says):
    with pytest.raises(RangeError, match=says):
        make()
