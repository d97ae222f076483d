#include "builtin/kalman/outlier_filter_tdoa.h"

#include <math.h>

#define INTEGRATOR_SIZE 300.0f        // [ms]
#define INTEGRATOR_RESUME 270.0f      // [ms], closes above
#define INTEGRATOR_FORCE_OPEN 30.0f   // [ms], opens below
#define LONGEST_STEP_MS 30u           // what one sample may count for
#define STD_DEVS_TO_FILL 2.0f         // the reservoir asks for a little more
#define STD_DEVS_TO_BE_ACCEPTED 2.5f  // than the closed gate

void outlierFilterTdoaReset(OutlierFilterTdoaState_t *this) {
  *this = (OutlierFilterTdoaState_t){.integrator = 0.0f, .isFilterOpen = true};
}

bool cf_tdoa_is_possible(const tdoaMeasurement_t *tdoa) {
  const point_t *a  = &tdoa->anchorPositions[0];
  const point_t *b  = &tdoa->anchorPositions[1];
  const float    dx = a->x - b->x;
  const float    dy = a->y - b->y;
  const float    dz = a->z - b->z;
  return tdoa->distanceDiff * tdoa->distanceDiff < dx * dx + dy * dy + dz * dz;
}

static void integrate(OutlierFilterTdoaState_t *this, bool fits, uint32_t nowMs) {
  const uint32_t elapsed = nowMs - this->latestUpdateMs;
  const float    step    = (float)(elapsed < LONGEST_STEP_MS ? elapsed : LONGEST_STEP_MS);
  this->integrator =
      fits ? fminf(this->integrator + step, INTEGRATOR_SIZE) : fmaxf(this->integrator - step, 0.0f);
}

bool outlierFilterTdoaValidateIntegrator(OutlierFilterTdoaState_t *this,
                                         const tdoaMeasurement_t *tdoa, float error,
                                         uint32_t nowMs) {
  if (!cf_tdoa_is_possible(tdoa)) {
    return false;
  }
  integrate(this, fabsf(error) < STD_DEVS_TO_FILL * tdoa->stdDev, nowMs);
  this->latestUpdateMs = nowMs;

  // opening and closing take effect with the next sample
  if (this->isFilterOpen) {
    this->isFilterOpen = !(this->integrator > INTEGRATOR_RESUME);
    return true;
  }
  this->isFilterOpen = this->integrator < INTEGRATOR_FORCE_OPEN;
  return fabsf(error) < STD_DEVS_TO_BE_ACCEPTED * tdoa->stdDev;
}
