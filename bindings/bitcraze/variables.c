/* Parameters and log variables that the vehicle declares in files which are not part of the
 * library: the estimator's task, and the half of collision_avoidance.c that belongs to the
 * vehicle. Names, types and flags are those of the builtin provider. */
#include "bitcraze/adapter.h"

#include "bitcraze/complementary_choice.h"
#include "bitcraze/own/complementary.h"
#include "bitcraze/own/motor_layer.h"
#include "bitcraze/variables.h"
#include "log.h"
#include "param.h"

#define STORED(name_, member_) \
  PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, name_, &cf_kalman_task.params.member_)

#if !CF_SYSTEM  // else theirs declare them

// the reset belongs to the task
PARAM_GROUP_START(kalman)
PARAM_ADD_CORE(PARAM_UINT8, robustTdoa, &cf_kalman_task.robust_tdoa)
PARAM_ADD_CORE(PARAM_UINT8, robustTwr, &cf_kalman_task.robust_twr)
STORED(pNAcc_xy, procNoiseAcc_xy)
STORED(pNAcc_z, procNoiseAcc_z)
STORED(pNVel, procNoiseVel)
STORED(pNPos, procNoisePos)
STORED(pNAtt, procNoiseAtt)
STORED(mNBaro, measNoiseBaro)
STORED(mNGyro_rollpitch, measNoiseGyro_rollpitch)
STORED(mNGyro_yaw, measNoiseGyro_yaw)
PARAM_ADD_CORE(PARAM_FLOAT, initialX, &cf_kalman_task.params.initialX)
PARAM_ADD_CORE(PARAM_FLOAT, initialY, &cf_kalman_task.params.initialY)
PARAM_ADD_CORE(PARAM_FLOAT, initialZ, &cf_kalman_task.params.initialZ)
PARAM_ADD_CORE(PARAM_FLOAT, initialYaw, &cf_kalman_task.params.initialYaw)
#if !CF_WITH_KALMAN_SUPERVISOR
PARAM_ADD_CORE(PARAM_FLOAT, maxPos, &cf_kalman_task.max_position)
PARAM_ADD_CORE(PARAM_FLOAT, maxVel, &cf_kalman_task.max_velocity)
#endif
#if HAVE_KALMAN_DRAG
STORED(dragB_x, dragB_x)
STORED(dragB_y, dragB_y)
STORED(dragB_z, dragB_z)
STORED(cop_x, cop_x)
STORED(cop_y, cop_y)
STORED(cop_z, cop_z)
#endif
PARAM_GROUP_STOP(kalman)

#define STATE(name_, index_) LOG_ADD(LOG_FLOAT, name_, &cf_kalman_task.core.S[index_])
#define VARIANCE(name_, index_) LOG_ADD(LOG_FLOAT, name_, &cf_kalman_task.core.P[index_][index_])
#define QUATERNION(name_, index_) LOG_ADD(LOG_FLOAT, name_, &cf_kalman_task.core.q[index_])

LOG_GROUP_START(kalman)
STATE(stateX, KC_STATE_X)
STATE(stateY, KC_STATE_Y)
STATE(stateZ, KC_STATE_Z)
STATE(statePX, KC_STATE_PX)
STATE(statePY, KC_STATE_PY)
STATE(statePZ, KC_STATE_PZ)
STATE(stateD0, KC_STATE_D0)
STATE(stateD1, KC_STATE_D1)
STATE(stateD2, KC_STATE_D2)
VARIANCE(varX, KC_STATE_X)
VARIANCE(varY, KC_STATE_Y)
VARIANCE(varZ, KC_STATE_Z)
VARIANCE(varPX, KC_STATE_PX)
VARIANCE(varPY, KC_STATE_PY)
VARIANCE(varPZ, KC_STATE_PZ)
VARIANCE(varD0, KC_STATE_D0)
VARIANCE(varD1, KC_STATE_D1)
VARIANCE(varD2, KC_STATE_D2)
QUATERNION(q0, 0)
QUATERNION(q1, 1)
QUATERNION(q2, 2)
QUATERNION(q3, 3)
LOG_GROUP_STOP(kalman)

LOG_GROUP_START(outlierf)
LOG_ADD(LOG_INT32, lhWin, &cf_kalman_task.sweep_window)
LOG_GROUP_STOP(outlierf)

#define AVOIDANCE(type_, name_, member_) PARAM_ADD(type_, name_, &cf_avoidance.params.member_)

PARAM_GROUP_START(colAv)
PARAM_ADD(PARAM_UINT8, enable, &cf_avoidance.enable)
AVOIDANCE(PARAM_FLOAT, ellipsoidX, ellipsoidRadii.x)
AVOIDANCE(PARAM_FLOAT, ellipsoidY, ellipsoidRadii.y)
AVOIDANCE(PARAM_FLOAT, ellipsoidZ, ellipsoidRadii.z)
AVOIDANCE(PARAM_FLOAT, bboxMinX, bboxMin.x)
AVOIDANCE(PARAM_FLOAT, bboxMinY, bboxMin.y)
AVOIDANCE(PARAM_FLOAT, bboxMinZ, bboxMin.z)
AVOIDANCE(PARAM_FLOAT, bboxMaxX, bboxMax.x)
AVOIDANCE(PARAM_FLOAT, bboxMaxY, bboxMax.y)
AVOIDANCE(PARAM_FLOAT, bboxMaxZ, bboxMax.z)
AVOIDANCE(PARAM_FLOAT, horizon, horizonSecs)
AVOIDANCE(PARAM_FLOAT, maxSpeed, maxSpeed)
AVOIDANCE(PARAM_FLOAT, sidestepThrsh, sidestepThreshold)
AVOIDANCE(PARAM_INT32, maxPeerLocAge, maxPeerLocAgeMillis)
AVOIDANCE(PARAM_FLOAT, vorTol, voronoiProjectionTolerance)
AVOIDANCE(PARAM_INT32, vorIters, voronoiProjectionMaxIters)
PARAM_GROUP_STOP(colAv)

LOG_GROUP_START(colAv)
LOG_ADD(LOG_UINT32, latency, &cf_avoidance.latency)
LOG_GROUP_STOP(colAv)

#endif

// -------------------------------------------------------------------------------------- our tables

static int give(cf_variables_t *tables, int capacity, const cf_variables_t *own, int count) {
  for (int i = 0; i < count && i < capacity; i++) {
    tables[i] = own[i];
  }
  return count;
}

int cf_own_parameters(cf_variables_t *tables, int capacity) {
  cf_variables_t own[3] = {cf_motor_layer_parameters()};
  int            count  = 1;
  if (!CF_COMPLEMENTARY_IS_THEIRS) {
    count += cf_own_complementary_parameters(&own[1]);
  }
  return give(tables, capacity, own, count);
}

int cf_own_logs(cf_variables_t *tables, int capacity) {
  cf_variables_t own[2];
  const int      count = CF_COMPLEMENTARY_IS_THEIRS ? 0 : cf_own_complementary_logs(own);
  return give(tables, capacity, own, count);
}
