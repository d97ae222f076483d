"""What clients look for is there, with the firmware's types (docs/reference/crtp-cflib.md#20)."""

import numpy as np
import pytest

from crazychoir_fw.onboard.variables import log_table, parameter_table

TYPES = {"u8": "u1", "u16": "u2", "u32": "u4", "i8": "i1", "i16": "i2", "i32": "i4", "f32": "f4"}

# group, type, names. Types of what only certain decks have, and which the reference calls integers, are our choice.
LOGS = """
stateEstimate f32 x y z vx vy vz roll pitch yaw qx qy qz qw ax ay az
stateEstimateZ i16 x y z vx vy vz ax ay az rateRoll ratePitch rateYaw
stateEstimateZ u32 quat
stabilizer f32 roll pitch yaw thrust rtStab
kalman f32 varPX varPY varPZ stateX stateY stateZ statePX statePY statePZ
gyro f32 x y z
acc f32 x y z
baro f32 asl temp pressure
mag f32 x y z
pm f32 vbat
pm u16 vbatMV
pm i8 state
pm u8 batteryLevel
range u16 front back left right up zrange
supervisor u16 info
sys u8 canfly isFlying isTumbled armed
motor u16 m1 m2 m3 m4
controller f32 roll pitch yaw rollRate pitchRate yawRate
posCtl f32 targetX targetY targetZ targetVX targetVY targetVZ
ctrltarget f32 x y z vx vy vz ax ay az roll pitch yaw
radio u8 rssi isConnected
radio u16 numRxBc numRxUc
crtp u16 rxRate txRate
ext_pos f32 X Y Z
locSrvZ u16 tick
memTst u32 errCntW
lighthouse u16 bsActive bsAvailable bsReceive bsCalVal bsCalCon bsCalUd bsGeoVal
lighthouse u8 status
ranging f32 distance0 distance1 distance2 distance3 distance4 distance5 distance6 distance7
ranging u16 state
"""

# group, type, flags (R read-only, P persistent, - neither), names
PARAMETERS = """
kalman u8 - resetEstimation
kalman f32 P pNAcc_xy pNAcc_z pNVel pNPos pNAtt mNBaro mNGyro_rollpitch mNGyro_yaw
kalman f32 - initialX initialY initialZ initialYaw
stabilizer u8 - controller estimator
commander u8 - enHighLevel
locSrv f32 - extPosStdDev extQuatStdDev
locSrv u8 - enRangeStreamFP32 enLhAngleStream enLhMtchStm minBsLhMtchStm maxTimeLhMtchStm
deck u8 R bcFlow bcFlow2 bcLighthouse4 bcLoco bcDWM1000
deck u8 R bcMultiranger bcZRanger2 bcLedRing bcBuzzer bcAI bcColorLedBot bcColorLedTop bcUSD
ring u8 P effect
ring u8 P solidRed solidGreen solidBlue
ring u8 - headlightEnable
ring u32 P fadeColor
ring f32 P fadeTime
led u8 - bitmask
pid_attitude f32 P roll_kp roll_ki roll_kd pitch_kp pitch_ki pitch_kd yaw_kp yaw_ki yaw_kd
pid_rate f32 P roll_kp roll_ki roll_kd pitch_kp pitch_ki pitch_kd yaw_kp yaw_ki yaw_kd
posCtlPid f32 P xKp xKi xKd yKp yKi yKd zKp zKi zKd
velCtlPid f32 P vxKp vxKi vxKd vyKp vyKi vyKd vzKp vzKi vzKd vxKFF vyKFF
ctrlMel f32 P kp_xy kd_xy ki_xy kp_z kd_z ki_z mass massThrust kR_xy kR_z kw_xy kw_z
flightmode u8 - althold poshold posSet yawMode stabModeRoll stabModePitch stabModeYaw
motorPowerSet u8 - enable
motorPowerSet u16 - m1 m2 m3 m4
health u8 - startPropTest startBatTest
system i8 R selftestPassed
system u8 - taskDump storageStats assertInfo
firmware u32 R revision0
firmware u16 R revision1
firmware u8 R modified
cpu u16 R flash
cpu u32 R id0 id1 id2
imu_sensors u8 R BMP3XX
sound u8 - effect
led_deck_ctrl u32 - rgb888
colorLedBot u32 - wrgb8888
colorLedBot u8 P brightCorr
colorLedBot u8 R throttlePct
colorLedTop u32 - wrgb8888
colorLedTop u8 P brightCorr
colorLedTop u8 R throttlePct
lighthouse u8 P systemType
lighthouse u8 - bsCalibReset method
memTst u8 - resetW
hlCommander f32 - vtoff vland
"""


def rows(text, columns):
    """Yield complete name and the columns before the names."""
    for line in text.strip().split("\n"):
        group, *rest = line.split()
        for name in rest[columns:]:
            yield f"{group}.{name}", *rest[:columns]


@pytest.mark.parametrize(("name", "kind"), list(rows(LOGS, 1)))
def test_log_variable_is_there(name, kind):
    assert log_table()[name].dtype == np.dtype(TYPES[kind])


@pytest.mark.parametrize(("name", "kind", "flag"), list(rows(PARAMETERS, 2)))
def test_parameter_is_there(name, kind, flag):
    row = parameter_table()[name]
    assert row.dtype == np.dtype(TYPES[kind])
    assert (row.is_read_only, row.is_persistent) == (flag == "R", flag == "P")
