#include <math.h>

#include "api/kalman_core.h"

#define SMALLEST_SQUARE \
  1e-4f  // [m^2], nearer to the edge of the light plane there is no derivative

// out = M in
static void turn(float out[3], const mat3d M, const vec3d in) {
  for (int i = 0; i < 3; i++) {
    out[i] = M[i][0] * in[0] + M[i][1] * in[1] + M[i][2] * in[2];
  }
}

// The sensor in the frame of the rotor.
static void sensor_in_rotor(vec3d sensor, const kalmanCoreData_t *core,
                            const sweepAngleMeasurement_t *sweep) {
  vec3d arm;
  turn(arm, core->R, *sweep->sensorPos);

  vec3d from_rotor;
  for (int i = 0; i < 3; i++) {
    from_rotor[i] = core->S[KC_STATE_X + i] + arm[i] - (*sweep->rotorPos)[i];
  }
  turn(sensor, *sweep->rotorRotInv, from_rotor);
}

void kalmanCoreUpdateWithSweepAngles(kalmanCoreData_t *self, const sweepAngleMeasurement_t *sweep,
                                     uint32_t nowMs, OutlierFilterLhState_t *state) {
  vec3d sensor;
  sensor_in_rotor(sensor, self, sweep);
  const float x  = sensor[0];
  const float y  = sensor[1];
  const float z  = sensor[2];
  const float r2 = x * x + y * y;

  const float predicted = sweep->calibrationMeasurementModel(x, y, z, sweep->t, sweep->calib);
  const float error     = sweep->measuredSweepAngle - predicted;
  if (!outlierFilterLighthouseValidateSweep(state, sqrtf(r2), error, nowMs)) {
    return;
  }

  // the derivative is that of ideal light planes, and by the position alone
  const float tan_t    = tanf(sweep->t);
  const float z_tan_t  = z * tan_t;
  const float distance = r2 - z_tan_t * z_tan_t;
  if (!(distance > SMALLEST_SQUARE)) {
    return;
  }
  const float q               = tan_t / sqrtf(distance);
  const vec3d g_of_rotor      = {(-y - x * z * q) / r2, (x - y * z * q) / r2, q};
  float       H[KC_STATE_DIM] = {0.0f};
  turn(&H[KC_STATE_X], *sweep->rotorRot, g_of_rotor);
  kalmanCoreScalarUpdate(self, H, error, sweep->stdDev);
}
