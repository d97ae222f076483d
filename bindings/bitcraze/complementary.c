/* The complementary estimator: what the checkout's estimator_complementary.c does with
 * sensfusion6.c and position_estimator_altitude.c, without its queue. */
#include "bitcraze/adapter.h"

#include "bitcraze/complementary_choice.h"
#include "bitcraze/conversions.h"
#include "bitcraze/own/complementary.h"

#if CF_COMPLEMENTARY_IS_THEIRS
#include "position_estimator.h"
#include "sensfusion6.h"

#define ATTITUDE_DT (1.0f / RATE_250_HZ)  // [s]
#define ALTITUDE_DT (1.0f / RATE_100_HZ)  // [s]

void cf_complementary_select(void *state CF_UNUSED) {
  sensfusion6Init();
}

void cf_complementary_run(void *state CF_UNUSED, const cf_latest_samples_t *latest,
                          api_state_t *estimate, api_stabilizerStep_t step,
                          uint32_t now_ms CF_UNUSED) {
  const api_Axis3f *gyro = &latest->gyro, *acc = &latest->acc;
  state_t           is = cf_checkout_state(estimate);
  if (step % (RATE_MAIN_LOOP / RATE_250_HZ) == 0) {
    quaternion_t *q = &is.attitudeQuaternion;
    sensfusion6UpdateQ(gyro->x, gyro->y, gyro->z, acc->x, acc->y, acc->z, ATTITUDE_DT);
    sensfusion6GetEulerRPY(&is.attitude.roll, &is.attitude.pitch, &is.attitude.yaw);
    sensfusion6GetQuaternion(&q->x, &q->y, &q->z, &q->w);
    is.acc.z = sensfusion6GetAccZWithoutGravity(acc->x, acc->y, acc->z);
    positionUpdateVelocity(is.acc.z, ATTITUDE_DT);
  }
  if (step % (RATE_MAIN_LOOP / RATE_100_HZ) == 0) {
    const baro_t           baro = cf_checkout_baro(&latest->baro);
    const tofMeasurement_t tof  = cf_checkout_tof(&latest->tof);
    positionEstimate(&is, &baro, &tof, ALTITUDE_DT, step);
  }
  cf_api_state(estimate, &is);
}
#else
void cf_complementary_select(void *state CF_UNUSED) {
  cf_library_print("ESTIMATOR: that of this firmware does not compile here, builtin's is used\n");
  cf_own_complementary_init();
}

void cf_complementary_run(void *state CF_UNUSED, const cf_latest_samples_t *latest,
                          api_state_t *estimate, api_stabilizerStep_t step, uint32_t now_ms) {
  const cf_own_samples_t samples = {
      .gyro         = {latest->gyro.x, latest->gyro.y, latest->gyro.z},
      .acc          = {latest->acc.x, latest->acc.y, latest->acc.z},
      .asl          = latest->baro.asl,
      .tof_ms       = latest->tof.timestamp,
      .tof_distance = latest->tof.distance,
  };
  api_quaternion_t *q  = &estimate->attitudeQuaternion;
  cf_own_estimate_t is = {
      .rpy        = {estimate->attitude.roll, estimate->attitude.pitch, estimate->attitude.yaw},
      .quaternion = {q->x, q->y, q->z, q->w},
      .acc_z      = estimate->acc.z,
      .position   = {estimate->position.x, estimate->position.y, estimate->position.z},
      .velocity_z = estimate->velocity.z,
  };
  cf_own_complementary_run(&samples, &is, step, now_ms);
  estimate->attitude.roll  = is.rpy[0];
  estimate->attitude.pitch = is.rpy[1];
  estimate->attitude.yaw   = is.rpy[2];
  q->x                     = is.quaternion[0];
  q->y                     = is.quaternion[1];
  q->z                     = is.quaternion[2];
  q->w                     = is.quaternion[3];
  estimate->acc.z          = is.acc_z;
  estimate->position.x     = is.position[0];
  estimate->position.y     = is.position[1];
  estimate->position.z     = is.position[2];
  estimate->velocity.z     = is.velocity_z;
}
#endif
