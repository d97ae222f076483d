// clang-format off
#include "mm_tdoa.h"
#include "test_support.h"
// clang-format on
#if MINIATURE_RELEASE >= 202502
#include "log.h"
#endif

#if CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK
#include "outlierFilterTdoaSteps.h"
#endif

// how many there were
TESTABLE_STATIC uint32_t tdoaCount = 0;
#if MINIATURE_RELEASE >= 202502
static float innovation;
#endif

void kalmanCoreUpdateWithTdoa(kalmanCoreData_t *this, tdoaMeasurement_t *tdoa, const uint32_t nowMs,
                              OutlierFilterTdoaState_t *outlierFilterState) {
  const point_t *A = &tdoa->anchorPositions[0], *B = &tdoa->anchorPositions[1];
  const float    x = this->S[KC_STATE_X], y = this->S[KC_STATE_Y], z = this->S[KC_STATE_Z];
  const float    ax = x - A->x, ay = y - A->y, az = z - A->z;
  const float    bx = x - B->x, by = y - B->y, bz = z - B->z;
  const float    a = sqrtf(ax * ax + ay * ay + az * az);
  const float    b = sqrtf(bx * bx + by * by + bz * bz);

#if MINIATURE_RELEASE >= 202502
  innovation = tdoa->distanceDiff - (b - a);
#else
  const float innovation = tdoa->distanceDiff - (b - a);
#endif
  if (a != 0.0f && b != 0.0f) {
    float                   h[KC_STATE_DIM] = {0};
    arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
    h[KC_STATE_X]                           = bx / b - ax / a;
    h[KC_STATE_Y]                           = by / b - ay / a;
    h[KC_STATE_Z]                           = bz / b - az / a;
#if CONFIG_ESTIMATOR_KALMAN_TDOA_OUTLIERFILTER_FALLBACK
    vector_t jacobian  = {.x = h[KC_STATE_X], .y = h[KC_STATE_Y], .z = h[KC_STATE_Z]};
    point_t  estimated = {.x = x, .y = y, .z = z};
    bool     isGood    = outlierFilterTdoaValidateSteps(tdoa, innovation, &jacobian, &estimated);
#else
    bool isGood = outlierFilterTdoaValidateIntegrator(outlierFilterState, tdoa, innovation, nowMs);
#endif
    if (isGood) {
      kalmanCoreScalarUpdate(this, &H, innovation, tdoa->stdDev);
    }
  }
  tdoaCount++;
}
#if MINIATURE_RELEASE >= 202502

LOG_GROUP_START(tdoa)
LOG_ADD(LOG_FLOAT, innovation, &innovation)
LOG_GROUP_STOP(tdoa)
#endif
