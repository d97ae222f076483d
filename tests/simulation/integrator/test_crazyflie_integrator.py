"""The integrator against closed forms, itself at finer steps, and the numbers of the original.

docs/reference/crazychoir.md#23.
"""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.attitude import angle_rates, quaternion_xyzw, rotation, wrapped
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.simulation.integrator import CrazyflieIntegrator, RandomForce

TILTED = {"init_pos": (0.0, 0.0, 1.0), "init_rpy": (0.1, -0.05, 0.2)}
WEIGHT = 0.038 * 9.81


def test_numbers_of_the_original():
    integrator = CrazyflieIntegrator(100, **TILTED, legacy=True)
    integrator.command(1.1 * 0.038 * 9.80665, 0.5, -0.3, 0.2)
    integrator.step(10)
    expected = [-0.001614628, -0.005944853, 1.004016494, 0.15, -0.08, 0.22, -0.03899262, -0.143054052, 0.087676115]
    assert integrator.state == pytest.approx(expected, abs=5e-10)
    assert integrator.rates == pytest.approx([0.515982939, -0.323656154, 0.250540209], abs=5e-10)
    assert integrator.odometry.rates.tolist() == integrator.rates.tolist()


@pytest.mark.parametrize("is_held", [True, False])
def test_the_method_is_of_degree_four(is_held):
    """Also where the input changes from one step to the next: it is held within a step."""

    def end(frequency):
        integrator = CrazyflieIntegrator(frequency, **TILTED, drag="rotor", wind=(0.5, 0.2, 0.0))
        for i in range(10):
            if i == 0 or not is_held:
                integrator.command(0.4 + 0.1 * np.sin(i), 2.0 * np.cos(i), -1.5, 3.0 * np.sin(2.0 * i))
            integrator.run(0.1)
        return integrator.state

    reference = end(3200)
    errors = np.array([np.abs(end(frequency) - reference).max() for frequency in (50, 100, 200)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all((orders > 3.8) & (orders < 4.3))
    assert errors[1] < 1e-6


def test_the_original_method_is_of_degree_one():
    def end(frequency):
        integrator = CrazyflieIntegrator(frequency, **TILTED, legacy=True)
        integrator.command(0.4, 1.0, -0.7, 0.5)
        integrator.run(1.0)
        return integrator.state

    errors = [np.abs(end(frequency) - end(6400)).max() for frequency in (50, 100)]
    assert errors[0] / errors[1] == pytest.approx(2.0, abs=0.1)


@given(*(st.floats(-1.2, 1.2) for _ in range(3)), *(st.floats(-5.0, 5.0) for _ in range(3)))
def test_body_rates_turn_the_matrix_as_they_should(roll, pitch, yaw, p, q, r):
    """The derivative of the attitude is R [w]x; the original took body rates for rates of the angles."""
    rpy, rates, h = np.array([roll, pitch, yaw]), np.array([p, q, r]), 1e-6
    change = (rotation(rpy + h * angle_rates(rpy, rates)) - rotation(rpy)) / h
    cross = np.array([[0.0, -r, q], [r, 0.0, -p], [-q, p, 0.0]])
    assert change == pytest.approx(rotation(rpy) @ cross, abs=1e-3)


@given(*(st.floats(-3.0, 3.0) for _ in range(3)))
def test_quaternion_and_matrix_agree(roll, pitch, yaw):
    rpy = np.array([roll, pitch, yaw])
    x, y, z, w = quaternion_xyzw(rpy)
    assert [2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)] == pytest.approx(rotation(rpy)[:, 2])
    assert x * x + y * y + z * z + w * w == pytest.approx(1.0)


def test_free_fall_is_a_parabola():
    integrator = CrazyflieIntegrator(100, init_pos=(0, 0, 10), init_vel=(1, 0, 2))
    integrator.command(0, 0, 0, 0)
    integrator.run(1.0)
    assert integrator.state == pytest.approx([1, 0, 10 + 2 - 9.81 / 2, 0, 0, 0, 1, 0, 2 - 9.81])


def test_a_drone_hovers_until_it_is_told_something():
    integrator = CrazyflieIntegrator(init_pos=(1, 2, 3))
    integrator.run(5.0)
    assert integrator.state == pytest.approx([1, 2, 3, 0, 0, 0, 0, 0, 0], abs=1e-12)


def test_drag_gives_a_terminal_velocity():
    integrator = CrazyflieIntegrator(20, init_pos=(0, 0, 0), platform="cf2", drag="rotor", wind=(2.0, 0.0, 0.0))
    assert integrator.mass == pytest.approx(0.029)
    integrator.command(0, 0, 0, 0)
    integrator.run(40.0)
    assert integrator.state[6:9] == pytest.approx([2.0, 0.0, -0.029 * 9.81 / 0.01677452], rel=1e-6)


def test_angles_are_wrapped():
    integrator = CrazyflieIntegrator(init_pos=(0, 0, 1))
    integrator.command(WEIGHT, 0, 0, 1.0)
    integrator.run(4.0)
    assert integrator.state[5] == pytest.approx(4.0 - 2 * np.pi)
    assert wrapped(np.array([np.pi, -np.pi])).tolist() == [-np.pi, -np.pi]


def test_many_drones_are_each_as_if_alone():
    starts = np.array([(0.0, 0.0, 1.0), (1.0, 0.0, 2.0), (2.0, 1.0, 0.5)])
    masses = np.array([0.03, 0.04, 0.05])

    def make(**options):
        return CrazyflieIntegrator(init_rpy=(0.1, 0.2, 0.3), drag=(0.01, 0.02, 0.03), **options)

    swarm = make(init_pos=starts, mass=masses, disturbance=RandomForce(0.01, seed=4))
    swarm.command(0.4, [0.1, 0.2, 0.3], -0.2, 0.0)
    swarm.run(1.0)
    assert swarm.state.shape == (3, 9)
    first = make(init_pos=starts[:1], mass=masses[:1], disturbance=RandomForce(0.01, seed=4))
    first.command(0.4, [0.1], -0.2, 0.0)
    first.run(1.0)
    # the second die is another one, so that only the first drone can fly alone
    assert first.state[0] == pytest.approx(swarm.state[0], abs=1e-12)


def test_odometry_comes_at_its_own_rate():
    heard = []
    integrator = CrazyflieIntegrator(100, odom_freq=30, **TILTED)
    integrator.odometry_listeners.append(heard.append)
    integrator.run(1.0)
    times = [message.time for message in heard]
    assert len(times) == 30
    assert np.diff(times).max() == pytest.approx(0.04)
    assert times[-1] == 1.0
    assert heard[-1].position.tolist() == integrator.state[:3].tolist()
    assert CrazyflieIntegrator(100).odom_freq == 100


def test_the_floor_holds_and_lets_go():
    integrator = CrazyflieIntegrator(init_pos=(0, 0, 0.5), init_rpy=(0.2, 0.1, 1.0), floor=0.0)
    integrator.command(0, 0, 0, 0)
    integrator.run(1.0)
    assert integrator.state == pytest.approx([integrator.state[0], integrator.state[1], 0, 0, 0, 1.0, 0, 0, 0])
    integrator.command(1.2 * WEIGHT, 0, 0, 0)
    integrator.run(1.0)
    assert integrator.state[2] > 0.5


def test_random_forces_have_their_size_and_repeat():
    def draw(seed, time_constant=0.5):
        force = RandomForce(0.02, time_constant, seed)
        return np.array([force.step(4, 0.01) for _ in range(5000)])

    forces = draw(1)
    assert forces.std() == pytest.approx(0.02, rel=0.1)
    lag = 50  # one time constant
    assert np.mean(forces[lag:] * forces[:-lag]) / np.mean(forces**2) == pytest.approx(np.exp(-1.0), abs=0.1)
    assert (forces == draw(1)).all()
    assert (forces != draw(2)).any()
    assert np.abs(np.corrcoef(forces[:, 0, 0], forces[:, 1, 0])[0, 1]) < 0.2


def test_start_is_drawn_from_the_agent_id():
    one, same, other = (CrazyflieIntegrator(agent_id=i).state for i in (3, 3, 4))
    assert one.tolist() == same.tolist()
    assert one.tolist() != other.tolist()
    assert np.all((one[:2] >= 0.0) & (one[:2] <= 3.0))
    assert one[2] == 0.0


@pytest.mark.parametrize("shape", [(3,), (2, 3)])
def test_other_commands_through_simple_loops(shape):
    integrator = CrazyflieIntegrator(init_pos=np.zeros(shape), drag="rotor")
    integrator.command_position((0.5, -0.2, 1.0), 2.0, yaw=0.8)
    integrator.run(1.0)
    velocity = integrator.state[..., 6:9]
    integrator.command_position((0.0, 0.0, 1.2), 2.0, yaw=-0.4)
    integrator.step()
    # planned on with the velocity that it had
    assert integrator.state[..., 6:9] == pytest.approx(velocity, abs=0.1)
    integrator.run(5.0)
    assert integrator.state[..., 0:3] == pytest.approx(np.broadcast_to((0.0, 0.0, 1.2), shape), abs=0.03)
    assert integrator.state[..., 5] == pytest.approx(-0.4, abs=0.01)

    integrator.command_velocity((0.3, 0.1, 0.2), yaw_rate=0.5)
    integrator.run(2.0)
    assert integrator.state[..., 6:9] == pytest.approx(np.broadcast_to((0.3, 0.1, 0.2), shape), abs=0.05)
    assert integrator.rates[..., 2] == pytest.approx(0.5, abs=0.05)

    integrator.command_attitude(WEIGHT, 0.1, -0.1, 0.3)
    integrator.run(2.0)
    assert integrator.state[..., 3:6] == pytest.approx(np.broadcast_to((0.1, -0.1, 0.3), shape), abs=1e-3)


def test_a_twist_is_thrust_and_rates():
    integrator = CrazyflieIntegrator()
    integrator.cmd_vel((0, 0, 0.3), (0.1, 0.2, 0.4))
    assert integrator.input.tolist() == [0.3, 0.1, 0.2, 0.4]


class LaggedThrust(CrazyflieIntegrator):
    """Rotors that take their time: one more state, and one method."""

    extra_states = 1
    lag = 0.07

    def derivative(self, time, state, command, force):
        thrust = state[..., 9:10]
        change = super().derivative(time, state, np.concatenate([thrust, command[..., 1:]], axis=-1), force)
        change[..., 9:10] = (command[..., 0:1] - thrust) / self.lag
        return change


def test_users_extend_the_dynamics():
    integrator = LaggedThrust(init_pos=(0, 0, 1))
    integrator.command(WEIGHT, 0, 0, 0)
    integrator.run(0.07)
    assert integrator.state[9] == pytest.approx(WEIGHT * (1 - np.exp(-1.0)), rel=1e-4)
    integrator.run(2.0)
    assert integrator.state[8] == pytest.approx(-9.81 * 0.07, rel=1e-4)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: CrazyflieIntegrator(0), "integration_freq is 0, allowed: a whole number of Hz"),
        (lambda: CrazyflieIntegrator(100, 200), "odom_freq is 200, allowed: a whole number of Hz, 1 to 100"),
        (lambda: CrazyflieIntegrator(mass=-1), "mass is -1, allowed: above 0 kg"),
        (lambda: CrazyflieIntegrator(init_pos=(1, 2)), r"init_pos has shape \(2,\), allowed: \(3,\) or \(N, 3\)"),
        (lambda: CrazyflieIntegrator(init_vel=(1, 2, np.nan)), "init_vel .*allowed: finite numbers"),
        (lambda: CrazyflieIntegrator().command(0.3, "x", 0, 0), "p is x, allowed: finite numbers"),
        (lambda: CrazyflieIntegrator().command(0.3, [1, 2], 0, 0), r"p has shape \(2,\), allowed: \(\)"),
        (lambda: CrazyflieIntegrator(init_pos=np.zeros((2, 3))).command([1, np.inf], 0, 0, 0), "f of drone 1 is"),
        (lambda: CrazyflieIntegrator().command_position((0, 0, 1), 0), "duration is 0, allowed: above 0 s"),
        (lambda: CrazyflieIntegrator().run(-1), r"run\(-1\)"),
        (lambda: RandomForce(-1), "sigma is -1"),
        (lambda: RandomForce(1, -1), "time_constant is -1"),
    ],
)
def test_bad_numbers_are_refused_by_name(make, sentence):
    with pytest.raises(RangeError, match=sentence):
        make()


def test_unknown_words_are_refused():
    with pytest.raises(UnknownNameError, match="platform is 'cf3', allowed: cf2, cf21bl"):
        CrazyflieIntegrator(platform="cf3")
    with pytest.raises(UnknownNameError, match="drag is 'air', allowed: rotor"):
        CrazyflieIntegrator(drag="air")


def test_a_state_that_runs_away_names_the_drone():
    class Wild(CrazyflieIntegrator):
        def derivative(self, time, state, command, force):
            change = super().derivative(time, state, command, force)
            change[1, 0] = np.inf
            return change

    with pytest.raises(RangeError, match="drone 1: the state is no longer finite after 0.000 s"):
        Wild(init_pos=np.zeros((2, 3))).step()
