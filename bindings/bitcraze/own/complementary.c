#include "bitcraze/own/complementary.h"

#include <string.h>

#include "builtin/complementary/complementary.h"
#include "library/image.h"

static cf_complementary_t own;

void cf_own_complementary_boot(void) {
  cf_complementary_boot(&own, CF_SENSFUSION6_MAHONY);
}

void cf_own_complementary_init(void) {
  cf_complementary_init(&own);
}

void cf_own_complementary_run(const cf_own_samples_t *latest, cf_own_estimate_t *estimate,
                              uint32_t step, uint32_t now_ms) {
  const cf_latest_samples_t samples = {
      .gyro = {.axis = {latest->gyro[0], latest->gyro[1], latest->gyro[2]}},
      .acc  = {.axis = {latest->acc[0], latest->acc[1], latest->acc[2]}},
      .baro = {.asl = latest->asl},
      .tof  = {.timestamp = latest->tof_ms, .distance = latest->tof_distance},
  };
  const float *q     = estimate->quaternion;
  state_t      state = {
      .attitude = {.roll = estimate->rpy[0], .pitch = estimate->rpy[1], .yaw = estimate->rpy[2]},
      .attitudeQuaternion = {.x = q[0], .y = q[1], .z = q[2], .w = q[3]},
      .position           = {.x = estimate->position[0],
                             .y = estimate->position[1],
                             .z = estimate->position[2]},
      .velocity           = {.z = estimate->velocity_z},
      .acc                = {.z = estimate->acc_z},
  };
  cf_complementary_update(&own, &samples, &state, step, now_ms);
  *estimate = (cf_own_estimate_t){
      .rpy        = {state.attitude.roll, state.attitude.pitch, state.attitude.yaw},
      .quaternion = {state.attitudeQuaternion.x, state.attitudeQuaternion.y,
                     state.attitudeQuaternion.z, state.attitudeQuaternion.w},
      .acc_z      = state.acc.z,
      .position   = {state.position.x, state.position.y, state.position.z},
      .velocity_z = state.velocity.z,
  };
}

static cf_variables_t over_block(cf_variables_t table, const void *part, size_t bytes) {
  table.base += (uint32_t)cf_image_offset(part, bytes);
  return table;
}

int cf_own_complementary_parameters(cf_variables_t tables[2]) {
  tables[0] = over_block(cf_sensfusion6_parameters(), &own.attitude, sizeof own.attitude);
  tables[1] = over_block(cf_altitude_parameters(), &own.altitude, sizeof own.altitude);
  return 2;
}

int cf_own_complementary_logs(cf_variables_t tables[2]) {
  tables[0] = over_block(cf_sensfusion6_logs(), &own.attitude, sizeof own.attitude);
  tables[1] = over_block(cf_altitude_logs(), &own.altitude, sizeof own.altitude);
  return 2;
}
