#include "mm_sweep_angles.h"

static void rotate(const mat3d *rotation, const vec3d in, vec3d out) {
  arm_matrix_instance_f32 R = {3, 3, (float32_t *)*rotation};
  arm_matrix_instance_f32 x = {3, 1, (float32_t *)in};
  arm_matrix_instance_f32 y = {3, 1, out};
  mat_mult(&R, &x, &y);
}

void kalmanCoreUpdateWithSweepAngles(kalmanCoreData_t *this, sweepAngleMeasurement_t *sweepInfo,
                                     const uint32_t          nowMs,
                                     OutlierFilterLhState_t *sweepOutlierFilterState) {
  vec3d arm, relative, sr;
  rotate((const mat3d *)&this->R, *sweepInfo->sensorPos, arm);
  for (int i = 0; i < 3; i++) {
    relative[i] = this->S[KC_STATE_X + i] + arm[i] - (*sweepInfo->rotorPos)[i];
  }
  rotate(sweepInfo->rotorRotInv, relative, sr);

  const float x = sr[0], y = sr[1], z = sr[2];
  const float r2   = x * x + y * y;
  const float tanT = tanf(sweepInfo->t);
  const float predicted =
      sweepInfo->calibrationMeasurementModel(x, y, z, sweepInfo->t, sweepInfo->calib);
  const float error = sweepInfo->measuredSweepAngle - predicted;
  if (outlierFilterLighthouseValidateSweep(sweepOutlierFilterState, arm_sqrt(r2), error, nowMs)) {
    const float zTanT = z * tanT;
    const float d     = r2 - zTanT * zTanT;
    if (d > 1e-4f) {
      const float             q               = tanT / arm_sqrt(d);
      vec3d                   g_r             = {(-y - x * z * q) / r2, (x - y * z * q) / r2, q};
      float                   h[KC_STATE_DIM] = {0};
      arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
      rotate(sweepInfo->rotorRot, g_r, &h[KC_STATE_X]);
      kalmanCoreScalarUpdate(this, &H, error, sweepInfo->stdDev);
    }
  }
}
