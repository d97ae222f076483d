"""What the processes of a mission are made of: lock step, waits, buttons, simulation, radio."""

import math
import runpy
import sys
import types
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from geometry_msgs.msg import PoseStamped, Twist
from nav_msgs.msg import Odometry
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Bool, Empty, String
from std_srvs.srv import Trigger

from crazychoir_fw.common.errors import RangeError, StateError, UnknownNameError
from crazychoir_fw.common.version import __version__
from crazychoir_fw.mission import load_mission
from crazychoir_fw.ros.buttons import Buttons, press_once
from crazychoir_fw.ros.lockstep import Answers
from crazychoir_fw.ros.manager import RosOptions, check
from crazychoir_fw.ros.names import BUTTONS, LATEST
from crazychoir_fw.ros.parts import parts_of
from crazychoir_fw.ros.plugins import PluginHost
from crazychoir_fw.ros.radio import RadioHandlerFPQR, RadioHandlerXYZ
from crazychoir_fw.ros.simulation import Pace, SimulationNode
from crazychoir_fw.ros.wall_timeouts import WallTimeoutClock
from crazychoir_fw.simulation import DroneConfig, World

ROOT = Path(__file__).resolve().parents[2]

# ---------------------------------------------------------------- waiting


def test_what_the_dead_said_before_does_not_bring_them_back():
    now = 0.0
    answers = Answers([(0, "answered"), (1, "answered")], clock=lambda: now)
    answers.expect_all()
    answers.ask()
    answers.take((0, "answered"))
    answers.bury((1, "answered"))
    assert answers.is_complete
    now = 0.1
    assert not answers.take((1, "answered"))  # it was on the way
    answers.ask()
    answers.take((0, "answered"))
    assert answers.is_complete
    now = 3.0
    assert answers.take((1, "answered"))  # it was started again
    answers.ask()
    answers.take((0, "answered"))
    assert not answers.is_complete


def test_who_lives_is_waited_for_and_who_is_silent_is_not():
    answers = Answers([(0, "cmd_vel"), (1, "cmd_vel")])
    answers.ask()
    assert answers.is_complete and not answers.is_anybody_there
    answers.take((0, "cmd_vel"))
    answers.ask()
    assert not answers.is_complete
    assert answers.missing == {(1, "cmd_vel")}
    answers.expect_all()
    answers.ask()
    assert not answers.take((0, "cmd_vel"))
    assert not answers.is_complete
    assert answers.give_up() == [(1, "cmd_vel")]
    answers.ask()
    answers.take((0, "cmd_vel"))
    assert answers.is_complete
    assert answers.take((1, "cmd_vel"))  # it was silent
    answers.ask()
    assert not answers.is_complete


def test_waits_count_where_time_stands_still_and_short_ones_do_not():
    now, wall = [10.0], [0.0]
    clock = WallTimeoutClock(lambda: now[0], 0.5, lambda: wall[0])
    assert clock.begin() == 10.0
    wall[0] = 0.4
    clock.look()
    assert clock.now() == 10.0
    now[0] = 10.01
    clock.look()
    wall[0] = 0.8
    clock.look()
    assert clock.now() == 10.01  # 0.4 s since it went on
    wall[0] = 0.9
    clock.look()
    assert clock.now() == pytest.approx(10.51)
    assert clock.begin() == pytest.approx(10.51)


# ---------------------------------------------------------------- buttons


def test_buttons_are_pressed_by_topic_and_by_service(bench):
    buttons = bench.add(Buttons(context=bench.context))
    heard = {name: bench.hear(Empty, topic.name) for name, topic in BUTTONS.items()}
    bench.until(lambda: all(buttons.listeners(name) for name in BUTTONS))
    buttons.press("takeoff")
    bench.until(lambda: heard["takeoff"])
    client = bench.user.create_client(Trigger, "/experiment_trigger")
    bench.until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    bench.until(answer.done)
    assert answer.result().success
    bench.until(lambda: heard["start"])
    assert not heard["land"] and not heard["stop"]
    with pytest.raises(UnknownNameError, match="jump.*takeoff"):
        buttons.press("jump")


def test_a_button_that_nobody_hears_says_so(bench):
    buttons = bench.add(Buttons(services=False, context=bench.context))
    with pytest.raises(StateError, match="nobody listens to /land"):
        buttons.press_when_heard("land", timeout=0.1)


@pytest.mark.parametrize("button", ["takeoff", "stop"])
def test_a_button_is_pressed_from_outside(bench, button):
    heard = bench.hear(Empty, f"/{button}")
    assert press_once(button, timeout=120.0) == 1
    bench.until(lambda: len(heard) == 1)


# ---------------------------------------------------------------- simulation


@pytest.fixture(scope="module")
def world():
    drones = [DroneConfig(f"agent_{i}", (float(i), 0.0), motor_ctrl="MotorCtrlVel") for i in range(2)]
    made = World(drones, seed=1, visuals=False)
    made.wait_until_ready()
    return made


def test_drones_of_a_world_are_topics(bench, world):
    node = bench.add(SimulationNode(PluginHost(world), command="vel", pace=Pace(None, True), context=bench.context))
    odometry = bench.hear(Odometry, "/agent_1/odom")
    speak = bench.speaker(Twist, "/agent_1/cmd_vel")
    idle = bench.user.create_publisher(Bool, "/agent_1/idle", LATEST)
    bench.until(lambda: idle.get_subscription_count())
    bench.until(lambda: node._odometry.publishers[1].get_subscription_count() > 0)
    climb = Twist()
    climb.linear.z = 0.5
    start = world.time
    while world.time < start + 1.0 - 1e-9:
        speak.publish(climb)
        bench.until(lambda: node.commands.is_new[1])
        node.step()
    bench.until(lambda: len(odometry) == 100)
    last = odometry[-1]
    assert last.header.stamp.sec + last.header.stamp.nanosec / 1e9 == pytest.approx(world.time)
    assert (last.header.frame_id, last.child_frame_id) == ("odom", "base_link")
    estimated = world["agent_1"].estimated_position
    assert last.pose.pose.position.z == pytest.approx(estimated[2], abs=1e-6)
    assert estimated[2] > 0.1
    assert world["agent_0"].true_position[2] < 0.05
    # resting is stronger than commands
    idle.publish(Bool(data=True))
    bench.until(lambda: node._idle[1])
    speak.publish(climb)
    bench.drain()
    assert world["agent_1"].motor_ctrl.is_stopped and not node.commands.take(~node._idle)[0].size
    idle.publish(Bool(data=False))
    bench.until(lambda: not node._idle[1])
    assert not world["agent_1"].motor_ctrl.is_stopped


def test_a_command_that_is_not_finite_reaches_no_drone(bench, world):
    node = bench.add(SimulationNode(PluginHost(world), command="vel", context=bench.context))
    bad, good = Twist(), Twist()
    bad.linear.x = math.nan
    for message in (bad, good):
        speak = bench.speaker(Twist, f"/agent_{0 if message is bad else 1}/cmd_vel")
        speak.publish(message)
    bench.until(lambda: node.commands.is_new[1])
    assert not node.commands.is_new[0]


def test_the_simulation_stops_at_the_button_until_it_may_go_on(bench, world):
    node = bench.add(SimulationNode(PluginHost(world), command="vel", context=bench.context))
    bench.speaker(Empty, "/stop").publish(Empty())
    bench.until(lambda: all(drone.motor_ctrl.is_stopped for drone in world.drones))
    node.resume_all()
    assert not any(drone.motor_ctrl.is_stopped for drone in world.drones)


@pytest.mark.parametrize("options", [{"command": "thrust"}, {"rate": 7.5}])
def test_simulation_refuses_what_it_cannot(bench, world, options):
    with pytest.raises(RangeError, match="allowed"):
        SimulationNode(PluginHost(world), context=bench.context, **options)


# ---------------------------------------------------------------- radio


class FakeHandler:
    """What a radio handler would be told."""

    def __init__(self, uris, **options):
        self.uris, self.options = uris, options
        self.calls = []

    def __getattr__(self, name):
        if name.startswith("on_"):
            raise AttributeError(name)
        return lambda *args: self.calls.append((name, *args))


URIS = {"uris": ["radio://0/80/2M/E7E7E7E703", "radio://0/80/2M/E7E7E7E704"], "agent_ids": [3, 4]}


def test_commands_buttons_and_poses_go_to_the_radio(bench):
    node = bench.add(RadioHandlerFPQR(make=FakeHandler, parameters=URIS, context=bench.context))
    calls = node.handler.calls
    assert node.handler.uris == dict(zip(["agent_3", "agent_4"], URIS["uris"], strict=True))
    assert calls == [("connect",)]
    command = Twist()
    command.linear.z, command.angular.y = 0.3, 1.5
    bench.speaker(Twist, "/agent_4/cmd_vel").publish(command)
    bench.until(lambda: ("cmd_vel", "agent_4", [0.0, 0.0, 0.3], [0.0, 1.5, 0.0]) in calls)
    pose = PoseStamped()
    pose.pose.position.x = 1.25
    pose.pose.orientation.w = 1.0
    bench.speaker(PoseStamped, "/vicon/cf3/cf3").publish(pose)
    bench.until(lambda: ("external_pose", "agent_3", [1.25, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]) in calls)
    for button in ("takeoff", "land", "stop"):
        bench.speaker(Empty, f"/{button}").publish(Empty())
        bench.until(lambda button=button: (button,) in calls)


def test_what_drones_say_becomes_topics(bench):
    parameters = {**URIS, "logger": True}
    node = bench.add(RadioHandlerFPQR(make=FakeHandler, parameters=parameters, context=bench.context))
    heard, battery = bench.hear(Odometry, "/agent_3/cf_odom"), bench.hear(BatteryState, "/agent_3/battery")
    states = bench.hear(String, "/agent_3/radio_state")
    bench.until(
        lambda: node._states["agent_3"].get_subscription_count() and node._odom["agent_3"].get_subscription_count()
    )
    bench.until(lambda: node._batteries["agent_3"].get_subscription_count())
    seen = types.SimpleNamespace(
        position=np.array([1.0, 2.0, 3.0]),
        quat_xyzw=np.array([0.0, 0.0, 0.0, 1.0]),
        velocity=np.array([0.1, 0.0, 0.0]),
        body_rates=np.zeros(3),
    )
    node.handler.on_odometry("agent_3", seen)
    node.handler.on_log("agent_3", {"pm.vbat": 3.9}, 1.0)
    node.handler.on_state("agent_3", "connected", "")
    bench.until(lambda: heard and battery and states)
    assert (heard[0].pose.pose.position.z, heard[0].twist.twist.linear.x) == (3.0, 0.1)
    assert battery[0].voltage == pytest.approx(3.9)
    assert states[0].data == "connected"


def test_radio_refuses_drones_without_number(bench):
    with pytest.raises(RangeError, match="2 uris and 1 agent_ids"):
        RadioHandlerXYZ(make=FakeHandler, parameters={**URIS, "agent_ids": [3]}, context=bench.context)


# ---------------------------------------------------------------- processes of a mission


def test_a_mission_falls_into_processes():
    mission = load_mission(ROOT / "examples" / "bearing_formation.yaml")
    assert parts_of(mission, "one") == []
    assert [part.name for part in parts_of(mission, "per-drone")] == ["agent_0", "agent_1", "agent_2", "agent_3"]
    names = [part.name for part in parts_of(mission, "per-node")]
    assert len(names) == 10 and "agent_0/planning" in names and "agent_2/planning" not in names


def test_what_cannot_fly_as_processes_is_refused():
    with pytest.raises(RangeError, match="per-process.*per-node"):
        check(load_mission(ROOT / "examples" / "bearing_formation.yaml"), RosOptions("per-process"))
    with pytest.raises(Exception, match="key layers"):
        check(load_mission(ROOT / "examples" / "hello_swarm.yaml"), RosOptions())


# ---------------------------------------------------------------- launch files, against a stand-in for ROS 2's package


class Recorded:
    def __init__(self, *args, **named):
        self.args, self.named = args, named

    def perform(self, context):
        return context[self.args[0]]


@pytest.fixture
def launch(monkeypatch):
    """What the launch files import; the package itself comes with a sourced ROS 2 only."""
    for module, names in {
        "launch": ["LaunchDescription"],
        "launch.actions": ["DeclareLaunchArgument", "ExecuteProcess", "OpaqueFunction"],
        "launch.substitutions": ["LaunchConfiguration"],
    }.items():
        stand_in = types.ModuleType(module)
        for name in names:
            setattr(stand_in, name, type(name, (Recorded,), {}))
        monkeypatch.setitem(sys.modules, module, stand_in)

    def load(name):
        described = runpy.run_path(str(ROOT / "launch" / name))["generate_launch_description"]()
        return {kind: [a for a in described.args[0] if type(a).__name__ == kind] for kind in LAUNCH_ACTIONS}

    return load


LAUNCH_ACTIONS = ("DeclareLaunchArgument", "ExecuteProcess", "OpaqueFunction")


@pytest.mark.parametrize("file", sorted(path.name for path in (ROOT / "launch").glob("*.launch.py")))
def test_every_launch_argument_is_described(launch, file):
    for argument in launch(file)["DeclareLaunchArgument"]:
        assert argument.named["description"]


def test_the_mission_is_launched_as_processes(launch):
    (function,) = launch("bearing_formation.launch.py")["OpaqueFunction"]
    mission = str(ROOT / "examples" / "bearing_formation.yaml")
    started = function.named["function"]({"mission": mission, "processes": "per-node", "speed": "1.0"})
    commands = [action.named["cmd"] for action in started]
    assert len(commands) == 11
    assert commands[0][3:] == ["simulation", mission, "--speed", "1.0"]
    assert ["layers", mission, "--drone", "agent_3", "--layer", "control"] in [list(c[3:]) for c in commands]


def test_the_package_of_ros_has_the_version_of_this_one():
    package = ET.parse(ROOT / "package.xml").getroot()
    assert package.findtext("version") == __version__
    assert package.findtext("name") == "crazychoir_fw"
