#include "mm_tdoa.h"

#include "log.h"
#include "test_support.h"

static float innovation;

void kalmanCoreUpdateWithTdoa(kalmanCoreData_t *this, tdoaMeasurement_t *tdoa, const uint32_t nowMs,
                              OutlierFilterTdoaState_t *outlierFilterState) {
  const point_t *A = &tdoa->anchorPositions[0], *B = &tdoa->anchorPositions[1];
  const float    x = this->S[KC_STATE_X], y = this->S[KC_STATE_Y], z = this->S[KC_STATE_Z];
  const float    ax = x - A->x, ay = y - A->y, az = z - A->z;
  const float    bx = x - B->x, by = y - B->y, bz = z - B->z;
  const float    a = sqrtf(ax * ax + ay * ay + az * az);
  const float    b = sqrtf(bx * bx + by * by + bz * bz);

  innovation = tdoa->distanceDiff - (b - a);
  if (a != 0.0f && b != 0.0f) {
    float                   h[KC_STATE_DIM] = {0};
    arm_matrix_instance_f32 H               = {1, KC_STATE_DIM, h};
    h[KC_STATE_X]                           = bx / b - ax / a;
    h[KC_STATE_Y]                           = by / b - ay / a;
    h[KC_STATE_Z]                           = bz / b - az / a;
    if (outlierFilterTdoaValidateIntegrator(outlierFilterState, tdoa, innovation, nowMs)) {
      kalmanCoreScalarUpdate(this, &H, innovation, tdoa->stdDev);
    }
  }
}

LOG_GROUP_START(tdoa)
LOG_ADD(LOG_FLOAT, innovation, &innovation)
LOG_GROUP_STOP(tdoa)
