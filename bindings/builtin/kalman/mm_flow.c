#include "builtin/kalman/mm_flow.h"

#include "builtin/kalman/constants.h"

#define PIXELS 35.0f          // of the sensor along one side
#define APERTURE 0.71674f     // 2 sin(42 deg / 2)
#define FLOW_RESOLUTION 0.1f  // motion pixels per count
#define SMALLEST_HEIGHT 0.1f  // [m]

void cf_mm_flow_update(kalmanCoreData_t *core, const flowMeasurement_t *flow, const Axis3f *gyro,
                       const Axis3f *lever_arm, cf_flow_log_t *log) {
  const float wx = gyro->x * DEG_TO_RAD;
  const float wy = gyro->y * DEG_TO_RAD;
  const float wz = gyro->z * DEG_TO_RAD;

  // both updates see the state from before the first
  const float z   = core->S[KC_STATE_Z] < SMALLEST_HEIGHT ? SMALLEST_HEIGHT : core->S[KC_STATE_Z];
  const float vx  = core->S[KC_STATE_PX] + (wy * lever_arm->z - wz * lever_arm->y);
  const float vy  = core->S[KC_STATE_PY] + (wz * lever_arm->x - wx * lever_arm->z);
  const float r22 = core->R[2][2];
  const float k   = flow->dt * PIXELS / APERTURE;

  log->predicted_x             = k * (vx * r22 / z - wy);
  log->measured_x              = flow->dpixelx * FLOW_RESOLUTION;
  const float Hx[KC_STATE_DIM] = {
      [KC_STATE_Z]  = k * (r22 * vx / (-z * z)),
      [KC_STATE_PX] = k * (r22 / z),
  };
  kalmanCoreScalarUpdate(core, Hx, log->measured_x - log->predicted_x,
                         flow->stdDevX * FLOW_RESOLUTION);

  log->predicted_y             = k * (vy * r22 / z + wx);
  log->measured_y              = flow->dpixely * FLOW_RESOLUTION;
  const float Hy[KC_STATE_DIM] = {
      [KC_STATE_Z]  = k * (r22 * vy / (-z * z)),
      [KC_STATE_PY] = k * (r22 / z),
  };
  kalmanCoreScalarUpdate(core, Hy, log->measured_y - log->predicted_y,
                         flow->stdDevY * FLOW_RESOLUTION);
}

void kalmanCoreUpdateWithFlow(kalmanCoreData_t *self, const flowMeasurement_t *flow,
                              const Axis3f *gyro) {
  const Axis3f  lever_arm = {.x = 0.0f, .y = 0.0f, .z = 0.0f};
  cf_flow_log_t log;
  cf_mm_flow_update(self, flow, gyro, &lever_arm, &log);
}
