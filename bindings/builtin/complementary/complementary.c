#include "builtin/complementary/complementary.h"

#define ATTITUDE_DT (1.0f / RATE_250_HZ)  // [s]
#define ALTITUDE_DT (1.0f / RATE_100_HZ)  // [s]

void cf_complementary_boot(cf_complementary_t *complementary, cf_sensfusion6_filter_t filter) {
  cf_sensfusion6_boot(&complementary->attitude, filter);
  cf_altitude_init(&complementary->altitude);
}

void cf_complementary_init(cf_complementary_t *complementary) {
  cf_sensfusion6_init(&complementary->attitude);
}

static void update_attitude(cf_complementary_t *self, const Axis3f *gyro, const Axis3f *acc,
                            state_t *estimate) {
  cf_sensfusion6_t *fusion = &self->attitude;
  cf_sensfusion6_update_q(fusion, gyro->x, gyro->y, gyro->z, acc->x, acc->y, acc->z, ATTITUDE_DT);

  attitude_t   *angles = &estimate->attitude;
  quaternion_t *q      = &estimate->attitudeQuaternion;
  cf_sensfusion6_get_euler_rpy(fusion, &angles->roll, &angles->pitch, &angles->yaw);
  cf_sensfusion6_get_quaternion(fusion, &q->x, &q->y, &q->z, &q->w);

  estimate->acc.z = cf_sensfusion6_get_acc_z_without_gravity(fusion, acc->x, acc->y, acc->z);
  cf_altitude_update_velocity(&self->altitude, estimate->acc.z, ATTITUDE_DT);
}

void cf_complementary_update(cf_complementary_t *complementary, const cf_latest_samples_t *latest,
                             state_t *estimate, stabilizerStep_t step, uint32_t now_ms) {
  if (step % (RATE_MAIN_LOOP / RATE_250_HZ) == 0) {
    update_attitude(complementary, &latest->gyro, &latest->acc, estimate);
  }
  if (step % (RATE_MAIN_LOOP / RATE_100_HZ) == 0) {
    cf_altitude_estimate(&complementary->altitude, estimate, &latest->baro, &latest->tof,
                         ALTITUDE_DT, now_ms);
  }
}
