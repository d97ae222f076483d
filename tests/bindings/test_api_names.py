"""Types, enumerations and functions of bindings/api against the reference's lists.

docs/reference/estimators.md#3.1 to #3.4 and #15; docs/reference/control-geometric.md#2.2, #2.4, #3.2, #4.1 to #4.9,
#6.1, #6.2, #7.1, #8, #9.1, #10.1 and #11.1, #11.2.
"""

import pytest

from crazychoir_fw._core import ffi, lib

# type: its members in order, views that overlap one after the other
MEMBERS = {
    # docs/reference/estimators.md#3.2, without the pointer Pm and with a counter of ours in the padding
    "kalmanCoreData_t": "S q R P baroReferenceHeight initialQuaternion isUpdated settled lastPredictionMs "
    "lastProcessNoiseUpdateMs",
    # docs/reference/estimators.md#3.4
    "point_t": "timestamp x y z",
    "velocity_t": "timestamp x y z",
    "acc_t": "timestamp x y z",
    "quaternion_t": "q0 q1 q2 q3 x y z w",
    "attitude_t": "timestamp roll pitch yaw",
    "tdoaMeasurement_t": "anchorPositions anchorPositionA anchorPositionB anchorIds anchorIdA anchorIdB distanceDiff "
    "stdDev",
    "baro_t": "pressure temperature asl",
    "positionMeasurement_t": "x y z pos stdDev source",
    "poseMeasurement_t": "x y z pos quat stdDevPos stdDevQuat",
    "distanceMeasurement_t": "x y z pos anchorId distance stdDev",
    "flowMeasurement_t": "timestamp dpixelx dpixely dpixel stdDevX stdDevY dt",
    "tofMeasurement_t": "timestamp distance stdDev coneHalfAngle",
    "heightMeasurement_t": "timestamp height stdDev",
    "yawErrorMeasurement_t": "timestamp yawError stdDev",
    "sweepAngleMeasurement_t": "timestamp sensorPos rotorPos rotorRot rotorRotInv sensorId baseStationId sweepId t "
    "measuredSweepAngle stdDev calib calibrationMeasurementModel",
    "gyroscopeMeasurement_t": "gyro",
    "accelerationMeasurement_t": "acc",
    "barometerMeasurement_t": "baro",
    "measurement_t": "type data",
    "Axis3f": "x y z axis",
    "state_t": "attitude attitudeQuaternion position velocity acc",
    "sensorData_t": "acc gyro mag baro interruptTimestamp",
    "OutlierFilterLhState_t": "openingTimeMs openingWindowMs",
    # docs/reference/control-geometric.md#2.4 and #4
    "control_t": "roll pitch yaw thrust thrustSi torque torqueX torqueY torqueZ normalizedForces controlMode",
    "struct vec": "x y z",
    "struct quat": "x y z w",
    "struct mat33": "m",
    # docs/reference/control-geometric.md#6.2
    "controllerMellinger_t": "mass massThrust kp_xy kd_xy ki_xy i_range_xy kp_z kd_z ki_z i_range_z kR_xy kw_xy "
    "ki_m_xy i_range_m_xy kR_z kw_z ki_m_z i_range_m_z kd_omega_rp i_error_x i_error_y i_error_z prev_omega_roll "
    "prev_omega_pitch prev_setpoint_omega_roll prev_setpoint_omega_pitch i_error_m_x i_error_m_y i_error_m_z "
    "z_axis_desired cmd_thrust cmd_roll cmd_pitch cmd_yaw r_roll r_pitch r_yaw accelz",
    # docs/reference/control-geometric.md#9.1 and #10.1; one filter of the thrust instead of three
    "struct FloatRates": "p q r",
    "struct ReferenceSystem": "err_p err_q err_r rate_p rate_q rate_r",
    "struct IndiVariables": "thrust angular_accel_ref du u_in u_act_dyn rate_d u rate g1 g2 reference_acceleration "
    "act_dyn filt_cutoff filt_cutoff_r",
    "struct Vectr": "x y z",
    "struct Angles": "phi theta psi",
    "struct IndiOuterVariables": "ddxi ang thr filt_cutoff act_dyn_posINDI linear_accel_ref linear_accel_err "
    "linear_accel_s linear_accel_f linear_accel_ft attitude_s attitude_f attitude_c phi_tilde theta_tilde T_tilde "
    "T_inner T_inner_f T_incremented",
    # docs/reference/control-geometric.md#11.2, with a number of ours at the end
    "controllerLee_t": "mass thrustSi J Kpos_P Kpos_P_limit Kpos_D Kpos_D_limit Kpos_I Kpos_I_limit i_error_pos "
    "p_error v_error KR Komega KI i_error_att rpy rpy_des R_des omega omega_r u max_thrust",
}


@pytest.mark.parametrize(("name", "members"), MEMBERS.items())
def test_type_has_the_members_of_the_firmware_in_its_order(name, members):
    assert [member for member, _ in ffi.typeof(name).fields] == members.split()


def test_measurement_holds_one_of_twelve():
    union = dict(ffi.typeof("measurement_t").fields)["data"].type
    members = "tdoa position pose distance tof height flow yawError sweepAngle gyroscope acceleration barometer"
    assert [member for member, _ in union.fields] == members.split()


# prefix: names of the values 0, 1, 2...
ENUMERATIONS = {
    "KC_STATE_": "X Y Z PX PY PZ D0 D1 D2 DIM",  # docs/reference/estimators.md#3.1
    "MeasurementType": "TDOA Position Pose Distance TOF AbsoluteHeight Flow YawError SweepAngle Gyroscope Acceleration "
    "Barometer",
    "MeasurementSource": "LocationService Lighthouse",
    "StateEstimatorType": "AutoSelect Complementary Kalman OutOfTree _COUNT",  # docs/reference/estimators.md#10.1
    "mode": "Disable Abs Velocity",  # docs/reference/control-geometric.md#2.2
    "controlMode": "Legacy ForceTorque Force PWM",
    # docs/reference/control-geometric.md#3.2
    "ControllerType": "AutoSelect PID Mellinger INDI Brescianini Lee Oot _COUNT",
}


@pytest.mark.parametrize(("prefix", "names"), ENUMERATIONS.items())
def test_enumeration_counts_as_in_the_firmware(prefix, names):
    values = [getattr(lib, prefix + name) for name in names.split()]
    assert values == list(range(len(values)))


# Where the firmware keeps state in a file, ours takes it as one more argument: Brescianini, INDI and the step gate.
# By section of docs/reference/estimators.md and docs/reference/control-geometric.md.
FUNCTIONS = {
    "estimators 15": "kalmanCoreDefaultParams kalmanCoreInit kalmanCoreUpdateWithBaro kalmanCorePredict "
    "kalmanCoreAddProcessNoise kalmanCoreFinalize kalmanCoreExternalizeState kalmanCoreDecoupleXY "
    "kalmanCoreScalarUpdate kalmanCoreUpdateWithPKE kalmanCoreUpdateWithAbsoluteHeight kalmanCoreUpdateWithPosition "
    "kalmanCoreUpdateWithPose kalmanCoreUpdateWithDistance kalmanCoreUpdateWithTof kalmanCoreUpdateWithYawError "
    "kalmanCoreUpdateWithFlow kalmanCoreUpdateWithTdoa kalmanCoreUpdateWithSweepAngles kalmanCoreRobustUpdateWithTdoa "
    "kalmanCoreRobustUpdateWithDistance outlierFilterTdoaReset outlierFilterTdoaValidateIntegrator "
    "outlierFilterTdoaValidateSteps outlierFilterLighthouseReset outlierFilterLighthouseValidateSweep "
    "axis3fSubSamplerInit axis3fSubSamplerAccumulate axis3fSubSamplerFinalize",
    "geometric 4.1": "fsqr radians degrees clamp fcloseulps",
    "geometric 4.2": "mkvec vrepeat vzero vbasis vscl vneg vdiv vadd vsub vdot veltmul veltdiv veltrecip vmag2 vmag "
    "vdist2 vdist vnormalize vclampnorm vcross vprojectunit vorthunit vabs vmin vmax vclamp vclampabs vmaxelt vminelt "
    "vnorm1 vadd3 vadd4 vsub2",
    "geometric 4.3": "veq vneq veqepsilon vless vleq vgreater vgeq visnan vload vstore vloadf vstoref vindex",
    "geometric 4.4": "mzero mdiag meyescl meye mcolumns mrows mcrossmat mcolumn mrow mtranspose mscl mneg madd msub "
    "madd3 mvmul mmul maddridge misnan set_block33_rowmaj maxisangle mrotx mroty mrotz",
    "geometric 4.5": "mkquat quatvw qeye qaxisangle qvectovec rpy2quat rpy2quat_small mat2quat quat2rpy quat2axis "
    "quat2angle quatimagpart quat2rotmat",
    "geometric 4.6": "qvrot qqmul qinv qneg qposreal qdot qanglebetween qeq qnormalize quat_gyro_update qnlerp qslerp "
    "qload qstore qloadf qstoref",
    "geometric 4.7": "vprojecthalfspace vinpolytope rayintersectpolytope vprojectpolytope",
    "geometric 4.9": "constrain deadband limitUint16 single2half half2single",
    "geometric 6.1": "controllerMellingerInit controllerMellingerReset controllerMellingerTest controllerMellinger",
    "geometric 7.1": "controllerBrescianiniInit controllerBrescianiniTest controllerBrescianini",
    "geometric 8": "init_butterworth_2_low_pass update_butterworth_2_low_pass get_butterworth_2_low_pass "
    "init_second_order_low_pass update_second_order_low_pass get_second_order_low_pass",
    "geometric 9.1": "controllerINDIInit controllerINDITest controllerINDI indi_init_filters",
    "geometric 10.1": "positionControllerINDIInit positionControllerINDI",
    "geometric 11.1": "controllerLeeInit controllerLeeReset controllerLee",
}


@pytest.mark.parametrize(("section", "names"), FUNCTIONS.items())
def test_functions_of_a_section_are_there(section, names):
    assert [name for name in names.split() if not hasattr(lib, name)] == []
