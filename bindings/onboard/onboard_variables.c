// Parameters and log variables of the loop itself (docs/reference/control-pid.md#17).

#include "onboard/onboard.h"
#include "variable_row.h"

#define STREAM(name_, flags_, member_) \
  CF_ROW("locSrv", name_, UINT8, flags_, cf_onboard_t, decks.lighthouse.member_)

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("stabilizer", "estimator", UINT8, CF_CORE, cf_onboard_t, estimator_type),
    CF_ROW("stabilizer", "controller", UINT8, CF_CORE, cf_onboard_t, controller_type),
    CF_ROW("locSrv", "enRangeStreamFP32", UINT8, CF_CORE, cf_onboard_t, decks.loco.streams),
    STREAM("enLhAngleStream", CF_CORE, streams_angles),
    CF_ROW("locSrv", "extPosStdDev", FLOAT, CF_CORE, cf_onboard_t, ext_pos_std_dev),
    CF_ROW("locSrv", "extQuatStdDev", FLOAT, CF_CORE, cf_onboard_t, ext_quat_std_dev),
    STREAM("enLhMtchStm", 0, streams_matched),
    STREAM("minBsLhMtchStm", 0, matched_stations),
    STREAM("maxTimeLhMtchStm", 0, matched_time),
};

#define STATE_Z(name, type) \
  CF_ROW("stateEstimateZ", #name, type, 0, cf_onboard_t, compressed_state.name)
#define TARGET_Z(name) \
  CF_ROW("ctrltargetZ", #name, INT16, 0, cf_onboard_t, compressed_setpoint.name)

static const cf_variable_t LOGS[] = {
    CF_ROW("ctrltarget", "x", FLOAT, CF_CORE, cf_onboard_t, setpoint.position.x),
    CF_ROW("ctrltarget", "y", FLOAT, CF_CORE, cf_onboard_t, setpoint.position.y),
    CF_ROW("ctrltarget", "z", FLOAT, CF_CORE, cf_onboard_t, setpoint.position.z),
    CF_ROW("ctrltarget", "vx", FLOAT, CF_CORE, cf_onboard_t, setpoint.velocity.x),
    CF_ROW("ctrltarget", "vy", FLOAT, CF_CORE, cf_onboard_t, setpoint.velocity.y),
    CF_ROW("ctrltarget", "vz", FLOAT, CF_CORE, cf_onboard_t, setpoint.velocity.z),
    CF_ROW("ctrltarget", "ax", FLOAT, CF_CORE, cf_onboard_t, setpoint.acceleration.x),
    CF_ROW("ctrltarget", "ay", FLOAT, CF_CORE, cf_onboard_t, setpoint.acceleration.y),
    CF_ROW("ctrltarget", "az", FLOAT, CF_CORE, cf_onboard_t, setpoint.acceleration.z),
    CF_ROW("ctrltarget", "roll", FLOAT, CF_CORE, cf_onboard_t, setpoint.attitude.roll),
    CF_ROW("ctrltarget", "pitch", FLOAT, CF_CORE, cf_onboard_t, setpoint.attitude.pitch),
    CF_ROW("ctrltarget", "yaw", FLOAT, CF_CORE, cf_onboard_t, setpoint.attitudeRate.yaw),
    TARGET_Z(x),
    TARGET_Z(y),
    TARGET_Z(z),
    TARGET_Z(vx),
    TARGET_Z(vy),
    TARGET_Z(vz),
    TARGET_Z(ax),
    TARGET_Z(ay),
    TARGET_Z(az),
    CF_ROW("stabilizer", "roll", FLOAT, 0, cf_onboard_t, estimate.attitude.roll),
    CF_ROW("stabilizer", "pitch", FLOAT, 0, cf_onboard_t, estimate.attitude.pitch),
    CF_ROW("stabilizer", "yaw", FLOAT, 0, cf_onboard_t, estimate.attitude.yaw),
    CF_ROW("stabilizer", "thrust", FLOAT, 0, cf_onboard_t, control.thrust),
    CF_ROW("stabilizer", "rtStab", FLOAT, 0, cf_onboard_t, loop_rate),
    CF_ROW("stabilizer", "intToOut", UINT32, 0, cf_onboard_t, int_to_out),
    CF_ROW("controller", "ctr_yaw", INT16, 0, cf_onboard_t, control_yaw),
    CF_ROW("stateEstimate", "x", FLOAT, CF_CORE, cf_onboard_t, estimate.position.x),
    CF_ROW("stateEstimate", "y", FLOAT, CF_CORE, cf_onboard_t, estimate.position.y),
    CF_ROW("stateEstimate", "z", FLOAT, CF_CORE, cf_onboard_t, estimate.position.z),
    CF_ROW("stateEstimate", "vx", FLOAT, CF_CORE, cf_onboard_t, estimate.velocity.x),
    CF_ROW("stateEstimate", "vy", FLOAT, CF_CORE, cf_onboard_t, estimate.velocity.y),
    CF_ROW("stateEstimate", "vz", FLOAT, CF_CORE, cf_onboard_t, estimate.velocity.z),
    CF_ROW("stateEstimate", "ax", FLOAT, CF_CORE, cf_onboard_t, estimate.acc.x),
    CF_ROW("stateEstimate", "ay", FLOAT, CF_CORE, cf_onboard_t, estimate.acc.y),
    CF_ROW("stateEstimate", "az", FLOAT, CF_CORE, cf_onboard_t, estimate.acc.z),
    CF_ROW("stateEstimate", "roll", FLOAT, CF_CORE, cf_onboard_t, estimate.attitude.roll),
    CF_ROW("stateEstimate", "pitch", FLOAT, CF_CORE, cf_onboard_t, estimate.attitude.pitch),
    CF_ROW("stateEstimate", "yaw", FLOAT, CF_CORE, cf_onboard_t, estimate.attitude.yaw),
    CF_ROW("stateEstimate", "qx", FLOAT, CF_CORE, cf_onboard_t, estimate.attitudeQuaternion.x),
    CF_ROW("stateEstimate", "qy", FLOAT, CF_CORE, cf_onboard_t, estimate.attitudeQuaternion.y),
    CF_ROW("stateEstimate", "qz", FLOAT, CF_CORE, cf_onboard_t, estimate.attitudeQuaternion.z),
    CF_ROW("stateEstimate", "qw", FLOAT, CF_CORE, cf_onboard_t, estimate.attitudeQuaternion.w),
    STATE_Z(x, INT16),
    STATE_Z(y, INT16),
    STATE_Z(z, INT16),
    STATE_Z(vx, INT16),
    STATE_Z(vy, INT16),
    STATE_Z(vz, INT16),
    STATE_Z(ax, INT16),
    STATE_Z(ay, INT16),
    STATE_Z(az, INT16),
    STATE_Z(quat, UINT32),
    STATE_Z(rateRoll, INT16),
    STATE_Z(ratePitch, INT16),
    STATE_Z(rateYaw, INT16),
    CF_ROW("motor", "m1", UINT16, CF_CORE, cf_onboard_t, motors.motors.m1),
    CF_ROW("motor", "m2", UINT16, CF_CORE, cf_onboard_t, motors.motors.m2),
    CF_ROW("motor", "m3", UINT16, CF_CORE, cf_onboard_t, motors.motors.m3),
    CF_ROW("motor", "m4", UINT16, CF_CORE, cf_onboard_t, motors.motors.m4),
    CF_ROW("motor", "m1req", INT32, 0, cf_onboard_t, compensated.motors.m1),
    CF_ROW("motor", "m2req", INT32, 0, cf_onboard_t, compensated.motors.m2),
    CF_ROW("motor", "m3req", INT32, 0, cf_onboard_t, compensated.motors.m3),
    CF_ROW("motor", "m4req", INT32, 0, cf_onboard_t, compensated.motors.m4),
    CF_ROW("ext_pos", "X", FLOAT, 0, cf_onboard_t, external_pose.x),
    CF_ROW("ext_pos", "Y", FLOAT, 0, cf_onboard_t, external_pose.y),
    CF_ROW("ext_pos", "Z", FLOAT, 0, cf_onboard_t, external_pose.z),
    CF_ROW("locSrv", "x", FLOAT, CF_CORE, cf_onboard_t, external_pose.x),
    CF_ROW("locSrv", "y", FLOAT, CF_CORE, cf_onboard_t, external_pose.y),
    CF_ROW("locSrv", "z", FLOAT, CF_CORE, cf_onboard_t, external_pose.z),
    CF_ROW("locSrv", "qx", FLOAT, CF_CORE, cf_onboard_t, external_pose.quat.x),
    CF_ROW("locSrv", "qy", FLOAT, CF_CORE, cf_onboard_t, external_pose.quat.y),
    CF_ROW("locSrv", "qz", FLOAT, CF_CORE, cf_onboard_t, external_pose.quat.z),
    CF_ROW("locSrv", "qw", FLOAT, CF_CORE, cf_onboard_t, external_pose.quat.w),
    CF_ROW("locSrvZ", "tick", UINT16, CF_CORE, cf_onboard_t, external_tick),
};

void cf_onboard_refresh_logs(cf_onboard_t *onboard) {
  onboard->compressed_state    = cf_compress_state(&onboard->estimate, &onboard->sensors.data.gyro);
  onboard->compressed_setpoint = cf_compress_setpoint(&onboard->setpoint);
}

cf_variables_t cf_onboard_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_onboard_logs(void) {
  return CF_TABLE(LOGS);
}
