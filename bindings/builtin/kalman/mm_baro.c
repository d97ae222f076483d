#include "builtin/kalman/scalar_update.h"

#define LOWEST_REFERENCE 1.0f  // [m], below it the reference counts as not set

void kalmanCoreUpdateWithBaro(kalmanCoreData_t *self, const kalmanCoreParams_t *params,
                              float baroAsl, bool quadIsFlying) {
  // on the ground here is zero
  if (!quadIsFlying || self->baroReferenceHeight < LOWEST_REFERENCE) {
    self->baroReferenceHeight = baroAsl;
  }

  const float measured = baroAsl - self->baroReferenceHeight;
  cf_scalar_update_single(self, KC_STATE_Z, 1.0f, measured - self->S[KC_STATE_Z],
                          params->measNoiseBaro);
}
