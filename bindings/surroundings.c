#include "surroundings.h"

#include <stddef.h>

float cf_look(const cf_surroundings_t *surroundings, const float point[3], const float direction[3],
              float cone, float reach) {
  if (surroundings != NULL) {
    return surroundings->distance(surroundings, point, direction, cone, reach);
  }
  const float distance = point[2] / -direction[2];
  // negated, so that NaN meets nothing
  return direction[2] < 0.0f && !(distance > reach) && distance >= 0.0f ? distance : reach;
}
