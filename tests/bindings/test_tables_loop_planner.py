"""Every parameter and log variable of the loop, the PID controller, the motors, the planner and the commanders.

Rows typed from docs/reference/control-pid.md#17, docs/reference/planner-commander.md#16 and
docs/reference/crtp-cflib.md#14 and #20: name, type, flags, value after boot. Decks, lighthouse, loco and ranging have
tests of their own.
"""

import numpy as np
import pytest

from crazychoir_fw.onboard.variables import factory_values, log_table, parameter_table

TYPES = {"u8": "u1", "u16": "u2", "u32": "u4", "i8": "i1", "i16": "i2", "i32": "i4", "float": "f4"}
FLAGS = {"core": "is_core", "persistent": "is_persistent", "read-only": "is_read_only"}
FLT_MAX = float(np.finfo(np.float32).max)

# name, type, flags, value on the cf2 [value on the cf21bl]
PARAMETERS = f"""
stabilizer.estimator u8 core 2
stabilizer.controller u8 core 1
stabilizer.stop u8 core 0

pid_attitude.roll_kp float persistent 6
pid_attitude.roll_ki float persistent 3
pid_attitude.roll_kd float persistent 0
pid_attitude.roll_kff float persistent 0
pid_attitude.pitch_kp float persistent 6
pid_attitude.pitch_ki float persistent 3
pid_attitude.pitch_kd float persistent 0
pid_attitude.pitch_kff float persistent 0
pid_attitude.yaw_kp float persistent 6
pid_attitude.yaw_ki float persistent 1
pid_attitude.yaw_kd float persistent 0.35
pid_attitude.yaw_kff float persistent 0
pid_attitude.yawMaxDelta float persistent 0
pid_attitude.attFiltEn i8 persistent 0
pid_attitude.attFiltCut float persistent 15

pid_rate.roll_kp float persistent 250 200
pid_rate.roll_ki float persistent 500 400
pid_rate.roll_kd float persistent 2.5
pid_rate.roll_kff float persistent 0
pid_rate.pitch_kp float persistent 250 200
pid_rate.pitch_ki float persistent 500 400
pid_rate.pitch_kd float persistent 2.5
pid_rate.pitch_kff float persistent 0
pid_rate.yaw_kp float persistent 120
pid_rate.yaw_ki float persistent 16.7
pid_rate.yaw_kd float persistent 0
pid_rate.yaw_kff float persistent 0
pid_rate.rateFiltEn i8 persistent 0
pid_rate.omxFiltCut float persistent 30
pid_rate.omyFiltCut float persistent 30
pid_rate.omzFiltCut float persistent 30

velCtlPid.vxKp float persistent 25
velCtlPid.vxKi float persistent 1
velCtlPid.vxKd float persistent 0
velCtlPid.vxKFF float persistent 0
velCtlPid.vyKp float persistent 25
velCtlPid.vyKi float persistent 1
velCtlPid.vyKd float persistent 0
velCtlPid.vyKFF float persistent 0
velCtlPid.vzKp float persistent 25
velCtlPid.vzKi float persistent 15
velCtlPid.vzKd float persistent 0
velCtlPid.vzKFF float persistent 0

posCtlPid.xKp float persistent 2
posCtlPid.xKi float persistent 0
posCtlPid.xKd float persistent 0
posCtlPid.xKff float persistent 0
posCtlPid.yKp float persistent 2
posCtlPid.yKi float persistent 0
posCtlPid.yKd float persistent 0
posCtlPid.yKff float persistent 0
posCtlPid.zKp float persistent 2
posCtlPid.zKi float persistent 0.5
posCtlPid.zKd float persistent 0
posCtlPid.zKff float persistent 0
posCtlPid.thrustBase u16 persistent 36000 30000
posCtlPid.thrustMin u16 persistent 20000
posCtlPid.rLimit float persistent 20
posCtlPid.pLimit float persistent 20
posCtlPid.xVelMax float persistent 1
posCtlPid.yVelMax float persistent 1
posCtlPid.zVelMax float persistent 1

powerDist.idleThrust u32 core,persistent 0 7000

motorPowerSet.enable u8 core 0
motorPowerSet.m1 u16 core 0
motorPowerSet.m2 u16 core 0
motorPowerSet.m3 u16 core 0
motorPowerSet.m4 u16 core 0

hlCommander.vtoff float core 0.5
hlCommander.vland float core 0.5
hlCommander.groupmask u8 core 0

commander.enHighLevel u8 core 0

flightmode.althold u8 core 0
flightmode.poshold u8 core 0
flightmode.posSet u8 core 0
flightmode.yawMode u8 - 2
flightmode.stabModeRoll u8 core 1
flightmode.stabModePitch u8 core 1
flightmode.stabModeYaw u8 core 0

cppm.rateRoll float persistent 720
cppm.ratePitch float persistent 720
cppm.angPitch float persistent 50
cppm.angRoll float persistent 50
cppm.rateYaw float persistent 400

colAv.enable u8 - 0
colAv.ellipsoidX float - 0.3
colAv.ellipsoidY float - 0.3
colAv.ellipsoidZ float - 0.9
colAv.bboxMinX float - {-FLT_MAX}
colAv.bboxMinY float - {-FLT_MAX}
colAv.bboxMinZ float - {-FLT_MAX}
colAv.bboxMaxX float - {FLT_MAX}
colAv.bboxMaxY float - {FLT_MAX}
colAv.bboxMaxZ float - {FLT_MAX}
colAv.horizon float - 1
colAv.maxSpeed float - 0.5
colAv.sidestepThrsh float - 0.25
colAv.maxPeerLocAge i32 - 5000
colAv.vorTol float - 1e-5
colAv.vorIters i32 - 100

supervisor.infdmp u8 - 0
supervisor.prefltTimeout u16 persistent 30000
supervisor.landedTimeout u16 persistent 3000
supervisor.tmblChckEn u8 persistent 1
"""


def names(group, members, type, flags="-"):
    """Return rows of one type."""
    return "\n".join(f"{group}.{name} {type} {flags}" for name in members.split())


AXES = "x y z vx vy vz ax ay az"

# name, type, flags
LOGS = "\n\n".join(
    [
        names(
            "controller",
            "cmd_thrust cmd_roll cmd_pitch cmd_yaw r_roll r_pitch r_yaw accelz actuatorThrust roll pitch yaw "
            "rollRate pitchRate yawRate",
            "float",
        )
        + "\ncontroller.ctr_yaw i16 -",
        *(
            names(
                group, " ".join(f"{a}_out{t}" for a in ("roll", "pitch", "yaw") for t in ("P", "I", "D", "FF")), "float"
            )
            for group in ("pid_attitude", "pid_rate")
        ),
        names(
            "posCtl",
            "targetVX targetVY targetVZ targetX targetY targetZ bodyVX bodyVY bodyX bodyY "
            + " ".join(f"{a}{t}" for a in ("X", "Y", "Z", "VX", "VY", "VZ") for t in ("p", "i", "d", "ff")),
            "float",
        ),
        names("ctrltarget", f"{AXES} roll pitch yaw", "float", "core"),
        names("ctrltargetZ", AXES, "i16"),
        names("stabilizer", "roll pitch yaw thrust rtStab", "float") + "\nstabilizer.intToOut u32 -",
        *(names(group, "x y z", "float", "core") for group in ("acc", "mag")),
        "baro.asl float core\nbaro.temp float -\nbaro.pressure float core",
        names("stateEstimate", f"{AXES} roll pitch yaw qx qy qz qw", "float", "core"),
        names("stateEstimateZ", AXES, "i16")
        + "\nstateEstimateZ.quat u32 -\n"
        + names("stateEstimateZ", "rateRoll ratePitch rateYaw", "i16"),
        names("motor", "m1 m2 m3 m4", "u16", "core") + "\n" + names("motor", "m1req m2req m3req m4req", "i32"),
        names("sys", "canfly isFlying isTumbled", "u8", "core") + "\nsys.armed u8 -",
        "supervisor.info u16 -",
        "colAv.latency u32 -",
    ]
)


def groups(rows):
    """Return the lines of a table by their group, in order."""
    found = {}
    for line in rows.split("\n"):
        if line:
            found.setdefault(line.split(".")[0], []).append(line)
    return found


def shown(variable, *values):
    """Return a variable as a line of the tables above."""
    type = next(name for name, dtype in TYPES.items() if variable.dtype == np.dtype(dtype))
    flags = ",".join(name for name, attribute in FLAGS.items() if getattr(variable, attribute))
    return " ".join([variable.name, type, flags or "-", *values])


def in_groups(table, group):
    return [variable for name, variable in table.items() if name.split(".")[0] == group]


def rounded(line):
    """Return a line with its last values as the drone holds them, one per platform."""
    name, type, flags, *values = line.split()
    dtype = np.dtype(TYPES[type])
    brushed, brushless = values[0], values[-1]
    return (name, type, flags, *(dtype.type(float(value)).item() for value in (brushed, brushless)))


@pytest.fixture(scope="module")
def boot():
    """Values after boot, by platform."""
    return {platform: factory_values(platform, parameter_table()) for platform in ("cf2", "cf21bl")}


@pytest.mark.parametrize(("group", "lines"), groups(PARAMETERS).items(), ids=groups(PARAMETERS))
def test_parameters_have_order_types_flags_and_values_of_the_reference(boot, group, lines):
    """docs/reference/control-pid.md#17, docs/reference/planner-commander.md#16."""
    found = [
        (*shown(row).split(), boot["cf2"][row.name], boot["cf21bl"][row.name])
        for row in in_groups(parameter_table(), group)
    ]
    assert found == [rounded(line) for line in lines]


@pytest.mark.parametrize(("group", "lines"), groups(LOGS).items(), ids=groups(LOGS))
def test_logs_have_types_and_flags_of_the_reference(group, lines):
    """Where two files make one group, their order is free.

    docs/reference/control-pid.md#17, docs/reference/planner-commander.md#16.
    """
    found = [shown(row) for row in in_groups(log_table(), group)]
    assert sorted(found) == sorted(lines)
    if group not in ("controller", "motor"):
        assert found == lines


def test_gyro_logs_begin_with_what_the_reference_lists():
    """Behind them come raw samples and variances (docs/reference/estimators.md#14.3)."""
    assert [shown(row) for row in in_groups(log_table(), "gyro")][:3] == names("gyro", "x y z", "float", "core").split(
        "\n"
    )


# ------------------------------------------------- what clients look for, docs/reference/crtp-cflib.md#14 and #20

# name, type; R for read-only, P for persistent
CLIENT_PARAMETERS = """
kalman.resetEstimation u8
kalman.pNAcc_xy float
kalman.initialX float
kalman.initialY float
kalman.initialZ float
kalman.initialYaw float
locSrv.extPosStdDev float
locSrv.extQuatStdDev float
ring.effect u8 P
ring.solidRed u8
ring.solidGreen u8
ring.solidBlue u8
ring.headlightEnable u8
ring.fadeColor u32
ring.fadeTime float
led.bitmask u8
health.startPropTest u8
health.startBatTest u8
system.selftestPassed i8 R
system.taskDump u8
system.storageStats u8
system.assertInfo u8
firmware.revision0 u32 R
firmware.revision1 u16 R
firmware.modified u8 R
cpu.flash u16 R
cpu.id0 u32 R
cpu.id1 u32 R
cpu.id2 u32 R
imu_sensors.BMP3XX u8 R
sound.effect u8
memTst.resetW u8
"""

CLIENT_LOGS = """
kalman.varPX float
kalman.varPY float
kalman.varPZ float
kalman.stateX float
kalman.stateY float
kalman.stateZ float
kalman.statePX float
kalman.statePY float
kalman.statePZ float
pm.vbat float
pm.vbatMV u16
pm.state i8
pm.batteryLevel u8
radio.rssi u8
radio.isConnected u8
radio.numRxBc u16
radio.numRxUc u16
crtp.rxRate u16
crtp.txRate u16
ext_pos.X float
ext_pos.Y float
ext_pos.Z float
locSrvZ.tick u16
memTst.errCntW u32
"""


def lines_of(text):
    return [line.split() for line in text.strip().split("\n")]


@pytest.mark.parametrize(("name", "type", "flag"), [(*row, "")[:3] for row in lines_of(CLIENT_PARAMETERS)])
def test_parameter_that_clients_look_for_has_its_type(name, type, flag):
    """docs/reference/crtp-cflib.md#14 and #20.2."""
    row = parameter_table()[name]
    assert row.dtype == np.dtype(TYPES[type])
    assert row.is_read_only == (flag == "R")
    assert row.is_persistent or flag != "P"


@pytest.mark.parametrize(("name", "type"), lines_of(CLIENT_LOGS))
def test_log_that_clients_look_for_has_its_type(name, type):
    """docs/reference/crtp-cflib.md#14 and #20.1."""
    assert log_table()[name].dtype == np.dtype(TYPES[type])


def test_external_positioning_has_the_deviations_of_the_reference(boot):
    """docs/reference/crtp-cflib.md#14."""
    for values in boot.values():
        assert values["locSrv.extPosStdDev"] == np.float32(0.01)
        assert values["locSrv.extQuatStdDev"] == np.float32(4.5e-3)


def test_battery_limits_are_those_of_the_platform(boot):
    """docs/reference/control-pid.md#12."""
    limits = {platform: (values["pm.lowVoltage"], values["pm.criticalLowVoltage"]) for platform, values in boot.items()}
    low = {"cf2": np.float32(3.2), "cf21bl": np.float32(3.35)}
    assert limits == {platform: (voltage, 3.0) for platform, voltage in low.items()}


@pytest.mark.parametrize(
    ("fetched", "rest"),
    [
        # the flight tab of cfclient fetches the thrust as 16 bits
        (2, "motor.m1 motor.m2 motor.m3 motor.m4 sys.canfly supervisor.info"),
        # poses of Crazyswarm2
        (0, "stateEstimate.x stateEstimate.y stateEstimate.z stabilizer.roll stabilizer.pitch stabilizer.yaw"),
    ],
)
def test_blocks_that_clients_ask_for_fit_into_a_packet(fetched, rest):
    """26 bytes of values at most (docs/reference/crtp-cflib.md#8.2, #19 and #20)."""
    assert fetched + sum(log_table()[name].dtype.itemsize for name in rest.split()) <= 26


@pytest.mark.parametrize("table", [parameter_table, log_table])
def test_names_fit_into_a_packet_of_the_table_of_contents(table):
    """At most 24 characters in group and name (docs/reference/crtp-cflib.md#8.1), in ASCII."""
    assert [name for name in table() if len(name) - 1 > 24 or not name.isascii() or name.count(".") != 1] == []
