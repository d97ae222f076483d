"""What was trained is what is flashed: the exported C against the policy in NumPy, by states and in whole flights."""

import ctypes
import subprocess
import sys

import numpy as np
import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.common.shared_folders import shared_folder
from crazychoir_fw.learning import Attitude, Hover, Motors, Observation, Residual, ThrustRates, Track, Velocity
from crazychoir_fw.learning.policy import Layer, Policy, cost_of, read_policy, write_app
from crazychoir_fw.learning.policy.reading import layers_of
from crazychoir_fw.learning.reading import Motion, Reading, Reference, rotation_of
from crazychoir_fw.learning.swarm_port import SwarmPort
from crazychoir_fw.simulation import DroneConfig, World
from tests.learning.policies import ALL, network

KINDS = [ThrustRates(), Attitude(), Velocity(), Residual(), Motors()]
ROUNDING = 2e-5  # of actions in [-1, 1]: some tens of float32 roundings of sums of 32 terms

HARNESS = """
#include "{source}"

void controllerPidInit(void) {{}}
bool controllerPidTest(void) {{ return true; }}
static setpoint_t seen;
void controllerPid(control_t *c, const setpoint_t *s, const sensorData_t *d, const state_t *t,
                   const stabilizerStep_t n) {{
  (void)c; (void)d; (void)t; (void)n;
  seen = *s;
}}

// per row: position, velocity, quaternion x y z w, gyro, acc, wanted position, velocity, acceleration, action before
void run(int count, const float *rows, float *actions, float *commands) {{
  for (int i = 0; i < count; i++, rows += 29) {{
    state_t      state   = {{0}};
    sensorData_t sensors = {{0}};
    setpoint_t   wanted  = {{0}};
    control_t    control = {{0}};
    memcpy(&state.position.x, rows, 12);
    memcpy(&state.velocity.x, rows + 3, 12);
    memcpy(&state.attitudeQuaternion, rows + 6, 16);
    memcpy(&gyro, rows + 10, 12);
    memcpy(&acc, rows + 13, 12);
    memcpy(&wanted.position.x, rows + 16, 12);
    memcpy(&wanted.velocity.x, rows + 19, 12);
    memcpy(&wanted.acceleration.x, rows + 22, 12);
    memcpy(action, rows + 25, 16);
    wanted.mode.x = wanted.mode.y = wanted.mode.z = modeAbs;
    isFlying = 1;
    height   = -1e9f;
    far      = 1e9f;
    controllerOutOfTree(&control, &wanted, &sensors, &state, PERIOD);
    memcpy(actions + 4 * i, action, 16);
    float *u = commands + 4 * i;
    if (control.controlMode == controlModeForce) {{
      memcpy(u, control.normalizedForces, 16);
    }} else if (seen.mode.x == modeVelocity) {{
      u[0] = seen.velocity.x; u[1] = seen.velocity.y; u[2] = seen.velocity.z; u[3] = seen.attitudeRate.yaw;
    }} else {{
      const attitude_t *a = seen.mode.roll == modeVelocity ? &seen.attitudeRate : &seen.attitude;
      u[0] = seen.thrust; u[1] = a->roll; u[2] = -a->pitch; u[3] = seen.attitudeRate.yaw;
    }}
  }}
}}
"""


def compiled(policy, folder):
    """The exported C with what is around it, as a function of arrays."""
    source = write_app(policy, folder)
    (folder / "harness.c").write_text(HARNESS.format(source=source.name))
    bindings = shared_folder("bindings")
    flags = ["-std=c11", "-O2", "-ffp-contract=off", "-Wall", "-Wextra", "-Werror", "-Wno-unused-parameter"]
    where = [f"-I{bindings / 'app' / 'include'}", f"-I{bindings / 'api'}", f"-I{bindings}"]
    library = folder / "policy.so"
    subprocess.run(["cc", *flags, *where, "-shared", "-fPIC", folder / "harness.c", "-o", library, "-lm"], check=True)
    function = ctypes.CDLL(str(library)).run

    def run(rows):
        rows = np.ascontiguousarray(rows, np.float32)
        actions, commands = np.empty((len(rows), 4), np.float32), np.empty((len(rows), 4), np.float32)
        function(len(rows), *(ctypes.c_void_p(array.ctypes.data) for array in (rows, actions, commands)))
        return actions, commands

    return run


def random_rows(count):
    rng = np.random.default_rng(1)
    rows = rng.uniform(-2.0, 2.0, (count, 29)).astype(np.float32)
    rows[:, 6:10] /= np.linalg.norm(rows[:, 6:10], axis=1, keepdims=True)
    rows[:, 10:13] *= 300.0  # deg/s
    rows[:, 25:] /= 2.0
    return rows


def reading_of(rows):
    radians, gravity = np.float32(np.pi / 180.0), np.float32(9.81)
    quat_wxyz = rows[:, (9, 6, 7, 8)]
    motion = Motion(rows[:, :3], rows[:, 3:6], rotation_of(quat_wxyz), rows[:, 10:13] * radians)
    reference = Reference(rows[:, 16:19], rows[:, 19:22], rows[:, 22:25])
    none = np.zeros(len(rows), np.float32)
    return Reading(
        *(motion, motion, rows[:, 13:16] * gravity, None, none, none > 1, none > 1, reference),
        *(rows[:, 25:], rows[:, 25:], none),
    )


@pytest.mark.parametrize("action", KINDS, ids=lambda action: action.kind)
def test_a_hundred_thousand_states_give_the_same_commands(action, tmp_path):
    policy = network(Observation(ALL), action, gain=0.5)
    rows = random_rows(100_000)
    actions, commands = compiled(policy, tmp_path)(rows)
    reading = reading_of(rows)
    expected = policy.act(policy.observation.of(reading))
    assert np.abs(actions - expected).max() < ROUNDING
    assert 0.2 < np.abs(expected).mean() < 0.95
    scale = action.scale("cf2")
    wanted = scale.of(expected)
    if action.kind == "residual":
        error = reading.reference.position - reading.estimate.position
        wanted[:, :3] += reading.reference.velocity + np.float32(action.gain) * error
    assert (np.abs(commands - wanted) <= ROUNDING * scale.gain + 1e-5 * np.abs(wanted) + 1e-6).all()


def state_bytes(drone):
    """What the controller saw in the tick that ended: estimate and setpoint."""
    onboard = drone.struct.onboard
    e, s = onboard.estimate, onboard.setpoint
    q = e.attitudeQuaternion
    row = [
        *(e.position.x, e.position.y, e.position.z, e.velocity.x, e.velocity.y, e.velocity.z, q.x, q.y, q.z, q.w),
        *[0.0] * 6,
        *(s.position.x, s.position.y, s.position.z, s.velocity.x, s.velocity.y, s.velocity.z),
        *(s.acceleration.x, s.acceleration.y, s.acceleration.z),
        *[0.0] * 4,
    ]
    return np.array(row, np.float32)


@pytest.mark.parametrize("action", [Residual(max_speed=0.1), Velocity(max_speed=0.1)], ids=lambda action: action.kind)
def test_a_whole_flight_of_the_app_is_that_of_the_policy(action, tmp_path):
    """Every action that the app took in a flight, against what the policy says of the same state."""
    policy = network(Observation(ALL), action, rate_hz=100)
    path = write_app(policy, tmp_path)
    world = World([DroneConfig("cf1", app=path)], seed=3)
    world.wait_until_ready()
    drone = world.drones[0]
    drone.high_level_commander.takeoff(0.8, 1.5)
    before = {"action": np.zeros(4, np.float32), "flies": False}
    seen = 0
    for tick in range(4000):
        if tick == 2500:
            drone.high_level_commander.go_to(0.3, 0.2, 1.0, 0.0, 1.0)
        data = drone.struct.onboard.sensors.data
        gyro, acc = np.array([*data.gyro.axis], np.float32), np.array([*data.acc.axis], np.float32)
        step = drone.struct.onboard.step
        world.step()
        if step % 10:
            continue
        action_now = np.array([drone.log[f"policy.a{k}"] for k in range(4)], np.float32)
        flies = bool(drone.log["policy.flies"])
        if flies:
            row = state_bytes(drone)
            row[10:13], row[13:16] = gyro, acc
            row[25:] = before["action"] if before["flies"] else 0.0
            expected = policy.act(policy.observation.of(reading_of(row[None])))[0]
            assert np.abs(action_now - expected).max() < ROUNDING, tick
            seen += 1
        before = {"action": action_now, "flies": flies}
    assert seen > 250


@pytest.mark.parametrize("action", [ThrustRates(), Attitude(), Motors()], ids=lambda action: action.kind)
def test_the_app_flies_what_the_environment_flies(action, tmp_path):
    """One drone is commanded as environments do, the other carries the app; both hover, then the policy takes over."""
    policy = stabilizing(action)
    path = write_app(policy, tmp_path)
    ours = World([DroneConfig("cf1", controller="pid")], seed=3)
    theirs = World([DroneConfig("cf1", app=path, parameters={"policy.enable": 0})], seed=3)
    for world in (ours, theirs):
        world.wait_until_ready()
        world.drones[0].high_level_commander.takeoff(1.0, 1.5)
        world.run(3.0)
        world.step(-int(world.drones[0].struct.onboard.step) % 40)
    assert np.array_equal(ours.positions(), theirs.positions())
    theirs.drones[0].param["policy.enable"] = 1
    port = SwarmPort(ours)
    scale, latest = action.scale("cf2"), np.zeros((1, 4), np.float32)
    still, none = np.zeros((1, 3), np.float32), np.zeros(1, np.float32)
    goal = ours.drones[0].struct.onboard.setpoint.position
    reference = Reference(np.array([[goal.x, goal.y, goal.z]], np.float32), still, still)
    apart = []
    for _ in range(150):
        estimate = port.estimate()
        reading = Reading(estimate, estimate, still, None, none, none > 1, none > 1, reference, latest, latest, none)
        latest = policy.act(policy.observation.of(reading))
        action.write(port, scale.of(latest), reading)
        for world in (ours, theirs):
            world.step(10)
        assert theirs.drones[0].log["policy.flies"] == 1
        apart.append(np.abs(ours.positions() - theirs.positions()).max())
    assert apart[4] < 1e-6
    assert max(apart) < 1e-3
    assert ours.positions()[0, 2] > 0.5


def stabilizing(action):
    """A network that is a linear law near hover, so that flights last: one layer, one tanh layer behind it."""
    observation = Observation(("position_error", "velocity_error", "rotation", "rates"))
    law = np.zeros((4, 18), np.float32)
    px, py, pz, vx, vy, vz = range(6)
    forward, left = 6 + 6, 6 + 7  # r31 = -sin(pitch), r32 = sin(roll)
    if action.kind == "motors":
        tilt, turn = 0.6, 0.08
        for motor, (roll, pitch, yaw) in enumerate([(-1, -1, -1), (-1, 1, 1), (1, 1, -1), (1, -1, 1)]):
            law[motor, [pz, vz]] = 0.6, 0.4
            law[motor, [py, vy, left, 15]] = -0.15 * roll, -0.15 * roll, -tilt * roll, -turn * roll
            law[motor, [px, vx, forward, 16]] = 0.15 * pitch, 0.15 * pitch, tilt * pitch, -turn * pitch
            law[motor, 17] = -0.02 * yaw
    else:
        gain = 1.0 if action.kind == "thrust_rates" else 0.5
        law[0, [pz, vz]] = 0.8, 0.6
        law[1, [py, vy]] = -0.3 * gain, -0.3 * gain
        law[2, [px, vx]] = 0.3 * gain, 0.3 * gain
        if action.kind == "thrust_rates":
            law[1, left], law[2, forward] = -1.0, 1.0
    identity = np.eye(4, dtype=np.float32)
    zero = np.zeros(4, np.float32)
    return Policy([Layer(law, zero, "tanh"), Layer(identity, zero, "none")], observation, action)


def test_a_saved_policy_is_the_same(tmp_path):
    policy = network(action=Motors(span=0.3), rate_hz=200)
    policy.save(tmp_path / "p.npz")
    again = read_policy(tmp_path / "p.npz")
    x = np.random.default_rng(0).standard_normal((50, policy.observation.size))
    assert np.array_equal(policy.act(x), again.act(x))
    assert (again.action, again.rate_hz, again.observation) == (policy.action, 200, policy.observation)


def test_layers_of_stable_baselines_leave_the_critic_out():
    policy = network()
    state = {"log_std": np.zeros(4)}
    for number, layer in enumerate(policy.layers[:2]):
        state[f"mlp_extractor.policy_net.{2 * number}.weight"] = layer.weight
        state[f"mlp_extractor.policy_net.{2 * number}.bias"] = layer.bias
        state[f"mlp_extractor.value_net.{2 * number}.weight"] = np.zeros((3, 3))
    state |= {"action_net.weight": policy.layers[2].weight, "action_net.bias": policy.layers[2].bias}
    found = layers_of(state, "relu")
    assert [layer.weight.shape for layer in found] == [layer.weight.shape for layer in policy.layers]
    assert [layer.activation for layer in found] == ["relu", "relu", "none"]


def test_an_onnx_file_is_read(tmp_path):
    onnx = pytest.importorskip("onnx")
    from onnx import TensorProto, helper, numpy_helper

    policy = network(activations=("tanh", "relu"))
    constants = {"mean": policy.mean, "std": 1.0 / policy.factor}
    nodes = [helper.make_node("Sub", ["x", "mean"], ["c"]), helper.make_node("Div", ["c", "std"], ["n"])]
    at = "n"
    for number, layer in enumerate(policy.layers):
        if number == 1:
            constants[f"w{number}"], constants[f"b{number}"] = layer.weight.T.copy(), layer.bias
            nodes.append(helper.make_node("MatMul", [at, f"w{number}"], [f"m{number}"]))
            nodes.append(helper.make_node("Add", [f"m{number}", f"b{number}"], [f"y{number}"]))
        else:
            constants[f"w{number}"], constants[f"b{number}"] = layer.weight, layer.bias
            nodes.append(helper.make_node("Gemm", [at, f"w{number}", f"b{number}"], [f"y{number}"], transB=1))
        at = f"y{number}"
        if layer.activation != "none":
            nodes.append(helper.make_node(layer.activation.capitalize(), [at], [f"a{number}"]))
            at = f"a{number}"
    graph = helper.make_graph(
        nodes,
        "policy",
        [helper.make_tensor_value_info("x", TensorProto.FLOAT, [None, policy.observation.size])],
        [helper.make_tensor_value_info(at, TensorProto.FLOAT, [None, 4])],
        [numpy_helper.from_array(np.asarray(value, np.float32), name) for name, value in constants.items()],
    )
    onnx.save(helper.make_model(graph), str(tmp_path / "p.onnx"))
    again = read_policy(tmp_path / "p.onnx", Hover())
    x = np.random.default_rng(0).standard_normal((50, policy.observation.size))
    assert np.abs(policy.act(x) - again.act(x)).max() < 1e-5


def test_the_cost_counts_every_product():
    policy = network(hidden=(64, 64), activations=("tanh", "tanh"))
    cost = cost_of(policy)
    size = policy.observation.size
    assert cost.multiply_adds == 64 * size + 64 * 64 + 64 * 4
    assert cost.flash_bytes > 4 * cost.multiply_adds
    assert "of 1 MB" in cost.rows["flash"]
    assert not cost.doubts
    big = network(hidden=(512, 512), activations=("relu", "relu"))
    assert len(cost_of(big).doubts) >= 2


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda f: write_app(network(Observation(source="truth")), f), "it sees the truth"),
        (lambda f: write_app(network(Observation(("rates", "battery"))), f), "it sees 'battery'"),
        (lambda f: write_app(network(), f, "My Policy"), "name is 'My Policy'"),
        (lambda f: network(hidden=(4,), activations=("sigmoid",)), "allowed: tanh, relu, none"),
        (
            lambda f: Policy([Layer(np.eye(3, dtype=np.float32), np.zeros(3, np.float32))], Observation(), Motors()),
            "22",
        ),
        (lambda f: read_policy(f / "none.npz"), "does not exist"),
        (lambda f: read_policy(f / "p.txt"), "a policy ends with"),
    ],
)
def test_what_cannot_be_flown_is_refused_in_one_sentence(make, words, tmp_path):
    with pytest.raises(CrazychoirError) as refused:
        make(tmp_path)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)


def test_a_damaged_file_is_refused(tmp_path):
    network().save(tmp_path / "p.npz")
    data = bytearray((tmp_path / "p.npz").read_bytes())
    (tmp_path / "cut.npz").write_bytes(data[: len(data) // 2])
    with pytest.raises(RangeError, match="is no policy"):
        read_policy(tmp_path / "cut.npz")


def test_the_command_writes_and_says_what_it_costs(tmp_path):
    network(Track().observation).save(tmp_path / "p.npz")
    result = CliRunner().invoke(app, ["app", "from-policy", str(tmp_path / "p.npz"), "--out", str(tmp_path / "a")])
    assert result.exit_code == 0, result.output
    assert (tmp_path / "a" / "policy.c").is_file()
    for word in ("multiply-adds", "of 1 MB", "of 192 KB", "168 MHz", "crazychoir fly"):
        assert word in result.output
    wrong = CliRunner().invoke(app, ["app", "from-policy", str(tmp_path / "q.npz")])
    assert wrong.exit_code == 2


def test_from_policy_needs_neither_gymnasium_nor_torch(tmp_path):
    network().save(tmp_path / "p.npz")
    code = (
        "import sys\n"
        "sys.modules['gymnasium'] = sys.modules['torch'] = None\n"
        "import importlib.util as u\n"
        "u_find = u.find_spec\n"
        "u.find_spec = lambda n, *a: None if n == 'gymnasium' else u_find(n, *a)\n"
        "from crazychoir_fw.learning.policy import read_policy, write_app\n"
        f"write_app(read_policy({str(tmp_path / 'p.npz')!r}), {str(tmp_path)!r})\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
    assert (tmp_path / "policy.c").is_file()
