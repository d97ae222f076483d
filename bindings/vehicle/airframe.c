#include "vehicle/airframe.h"

#include "vehicle/valid.h"

cf_status_t cf_airframe_check(const cf_airframe_t *airframe) {
  if (!cf_is_positive(airframe->mass) || !cf_is_not_negative(airframe->landed_height)) {
    return CF_ERR_VALUE;
  }
  for (int i = 0; i < 3; i++) {
    if (!cf_is_positive(airframe->inertia[i]) ||
        !cf_is_within(airframe->products_of_inertia[i], -CF_ANY_SIZE, CF_ANY_SIZE) ||
        !cf_is_within(airframe->trim_torque[i], -CF_ANY_SIZE, CF_ANY_SIZE)) {
      return CF_ERR_VALUE;
    }
  }
  return cf_downwash_check(&airframe->downwash);
}
