"""When what is computed and sent, and which reference is followed."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose, Reference
from crazychoir_fw.control import (
    AttitudeCtrlStrategy,
    CrazyflieController,
    FlatnessAccelerationCtrl,
    FlatnessPositionCtrl,
    FPQRSender,
    FRPYSender,
    GeometryAttitudeCtrl,
    HierarchicalController,
    PositionCtrlStrategy,
)
from crazychoir_fw.simulation.integrator import CrazyflieIntegrator


class NotedPosition(PositionCtrlStrategy):
    """Writes down what it is asked."""

    def __init__(self, update_frequency=100.0):
        super().__init__(update_frequency)
        self.asked = []

    def control(self, current_pose, desired_reference):
        self.asked.append(desired_reference)
        self.desired_rates = np.full(3, float(len(self.asked)))
        return np.asarray(float(len(self.asked))), np.eye(3)


class NotedAttitude(AttitudeCtrlStrategy):
    def control(self, current_pose, desired_attitude, desired_reference):
        return self.desired_rates


def still(*position):
    return Pose(np.array(position), np.array([0.0, 0.0, 0.0, 1.0]), np.zeros(3), np.zeros(3))


def noted(position_rate=100.0, rate=100.0):
    controller = HierarchicalController(NotedPosition(position_rate), NotedAttitude(rate), FPQRSender(rate))
    controller.set_pose(still(0.0, 0.0, 1.0))
    return controller, controller.position_strategy


# ---------------------------------------------------------------- scheduling


def test_one_frequency_one_step():
    controller, law = noted()
    assert controller.periods == (0.01,)
    thrusts = [controller.step(0.01 * i).linear[2] for i in range(5)]
    assert thrusts == [1.0, 2.0, 3.0, 4.0, 5.0]
    assert len(law.asked) == 5


def test_a_slow_position_law_is_asked_less_often():
    controller, _ = noted(position_rate=20.0)
    assert controller.periods == (0.05, 0.01)
    thrusts = [controller.step(0.01 * i).linear[2] for i in range(11)]
    assert thrusts == [1.0] * 5 + [2.0] * 5 + [3.0]


def test_a_fast_position_law_sends_no_more_often():
    controller, law = noted(position_rate=100.0, rate=50.0)
    sent = [controller.step(0.01 * i) is not None for i in range(10)]
    assert sent == [True, False] * 5
    assert len(law.asked) == 10


def test_nothing_happens_before_it_is_due():
    controller, law = noted()
    sent = [controller.step(0.001 * i) is not None for i in range(31)]
    assert np.flatnonzero(sent).tolist() == [0, 10, 20, 30]
    assert len(law.asked) == 4


@pytest.mark.parametrize("rate", [30.0, 100.0, 333.0])
def test_a_clock_that_sums_up_floats_drifts_by_nothing(rate):
    controller, law = noted(rate, rate)
    sum_of_steps = 0.0
    for _ in range(20_000):
        assert controller.step(sum_of_steps) is not None
        sum_of_steps += 1.0 / rate
    assert len(law.asked) == 20_000


def test_what_was_missed_is_not_made_up_for():
    controller, _ = noted()
    controller.step(0.0)
    assert controller.step(0.057) is not None
    assert controller.step(0.058) is None
    assert controller.step(0.060) is not None


def test_a_clock_that_goes_back_starts_anew():
    controller, _ = noted()
    controller.step(100.0)
    assert controller.step(0.0) is not None
    assert controller.step(0.005) is None
    assert controller.step(0.01) is not None


@pytest.mark.parametrize("missing", ["position", "velocity", "orientation"])
def test_nothing_is_sent_before_the_pose_is_known(missing):
    controller, law = noted()
    pose = still(0.0, 0.0, 1.0)
    setattr(pose, missing, None)
    controller.set_pose(pose)
    assert controller.step(0.0) is None
    assert not law.asked
    controller.set_pose(still(0.0, 0.0, 1.0))
    assert controller.step(0.003) is not None


def test_hover_until_the_position_law_was_asked():
    controller = HierarchicalController(FlatnessPositionCtrl(mass=0.03), None, FRPYSender())
    assert controller.thrust == pytest.approx(0.03 * 9.80665)
    assert np.array_equal(controller.desired_attitude, np.eye(3))
    assert np.array_equal(controller.desired_pqr, np.zeros(3))


def test_desired_rates_reach_the_attitude_law():
    controller, _ = noted()
    controller.step(0.0)
    assert controller.step(0.01).angular.tolist() == [2.0, 2.0, 2.0]


# ---------------------------------------------------------------- references


def test_without_a_reference_the_first_position_is_kept():
    controller, law = noted()
    controller.step(0.0)
    controller.set_pose(still(5.0, 5.0, 5.0))
    controller.step(0.01)
    for reference in law.asked:
        assert reference.position.tolist() == [0.0, 0.0, 1.0]
        assert reference.velocity.tolist() == reference.acceleration.tolist() == [0.0, 0.0, 0.0]
        assert reference.yaw == 0.0


def test_the_last_reference_is_held_for_ever():
    controller, law = noted()
    reference = Reference(position=np.ones(3))
    controller.set_reference(reference)
    for now in (0.0, 10.0, 1000.0):
        controller.step(now)
    assert all(asked is reference for asked in law.asked)


def test_a_cleared_reference_keeps_the_drone_where_it_is():
    controller, law = noted()
    reference = Reference(position=np.ones(3))
    controller.step(0.0)
    controller.set_reference(reference)
    controller.step(0.01)
    controller.clear_reference()
    controller.set_pose(still(2.0, 0.0, 1.0))
    controller.step(0.02)
    assert law.asked[-1].position.tolist() == [2.0, 0.0, 1.0]
    controller.set_reference(reference)
    controller.step(0.03)
    assert law.asked[-1] is reference


@pytest.mark.parametrize("law", [FlatnessAccelerationCtrl, FlatnessPositionCtrl])
def test_without_a_reference_a_moving_drone_comes_back_to_where_it_was(law):
    drone = CrazyflieIntegrator(init_pos=(0.0, 0.0, 1.0), gravity=9.80665)

    def pose():
        seen = drone.odometry
        return Pose(seen.position, seen.quat_xyzw, seen.velocity, seen.rates)

    controller = HierarchicalController(law(), GeometryAttitudeCtrl(), FPQRSender())
    for k in range(700):
        controller.set_pose(pose())
        if k == 0:
            controller.set_reference(Reference(acceleration=np.array([1.0, -0.5, 0.4]), velocity=np.ones(3)))
        if k == 100:
            controller.clear_reference()
            left = pose()
        command = controller.step(0.01 * k)
        drone.command(command.linear[2], *command.angular)
        drone.step()
    assert np.linalg.norm(left.velocity) > 0.5
    end = pose()
    np.testing.assert_allclose(end.position, left.position, atol=0.02)
    np.testing.assert_allclose(end.velocity, 0.0, atol=0.02)


def test_references_go_through_the_trajectory_handler():
    class OnlyAcceleration:
        kept = None

        def update(self, reference):
            self.kept = Reference(acceleration=reference.acceleration)

        def get_desired_reference(self):
            return self.kept

    law = NotedPosition()
    controller = HierarchicalController(law, NotedAttitude(), FPQRSender(), OnlyAcceleration())
    controller.set_pose(still(0.0, 0.0, 0.0))
    controller.set_reference(Reference(position=np.ones(3), acceleration=np.ones(3)))
    controller.step(0.0)
    assert law.asked[0].position is None
    assert law.asked[0].acceleration.tolist() == [1.0, 1.0, 1.0]


def test_a_group_is_flown_by_one_controller():
    poses = Pose(*(np.random.default_rng(1).normal(size=(30, n)) for n in (3, 4, 3, 3)))
    controller = HierarchicalController(FlatnessPositionCtrl(), GeometryAttitudeCtrl(), FPQRSender())
    controller.set_pose(poses)
    twist = controller.step(0.0)
    assert twist.linear.shape == twist.angular.shape == (30, 3)
    assert np.all(twist.linear[:, 2] >= 0.0)


# ---------------------------------------------------------------- as the paper prints it, and mistakes


def test_both_spellings_of_the_position_law():
    law = FlatnessAccelerationCtrl()
    parts = {"attitude_strategy": GeometryAttitudeCtrl(), "command_sender": FPQRSender()}
    assert HierarchicalController(pos_strategy=law, **parts).position_strategy is law
    assert HierarchicalController(position_strategy=law, **parts).position_strategy is law


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"command_sender": None}, "command_sender is None, allowed: FPQRSender, FRPYSender, VelSender"),
        (
            {"attitude_strategy": GeometryAttitudeCtrl(50.0)},
            "attitude_strategy runs at 50 Hz and command_sender",
        ),
        ({"pos_strategy": None}, "neither of pos_strategy and position_strategy is given"),
        ({"position_strategy": FlatnessPositionCtrl()}, "both of pos_strategy and position_strategy"),
        ({"attitude_strategy": None}, "attitude_strategy is None, allowed with thrust and body rates: an attitude law"),
    ],
)
def test_parts_that_do_not_fit_are_refused(arguments, message):
    parts = {
        "pos_strategy": FlatnessPositionCtrl(),
        "attitude_strategy": GeometryAttitudeCtrl(),
        "command_sender": FPQRSender(),
    }
    with pytest.raises(RangeError, match=f"HierarchicalController: {message}") as caught:
        HierarchicalController(**parts | arguments)
    assert isinstance(caught.value, ValueError)


def test_the_template_computes_nothing():
    with pytest.raises(TypeError, match="abstract"):
        CrazyflieController(FPQRSender())
