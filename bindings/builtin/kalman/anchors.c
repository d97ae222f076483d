#include "builtin/kalman/anchors.h"

#include <math.h>

// From an anchor to a place.
typedef struct {
  float x;  // [m]
  float y;
  float z;
  float length;
} ray_t;

static ray_t ray_to(const float X[KC_STATE_DIM], float anchor_x, float anchor_y, float anchor_z) {
  const float x = X[KC_STATE_X] - anchor_x;
  const float y = X[KC_STATE_Y] - anchor_y;
  const float z = X[KC_STATE_Z] - anchor_z;
  return (ray_t){.x = x, .y = y, .z = z, .length = sqrtf(x * x + y * y + z * z)};
}

cf_linearization_t cf_linearize_distance(const float                  X[KC_STATE_DIM],
                                         const distanceMeasurement_t *distance) {
  const ray_t        ray = ray_to(X, distance->x, distance->y, distance->z);
  cf_linearization_t at  = {.error = distance->distance - ray.length, .has_derivative = true};

  // H = ray / |ray|
  if (ray.length == 0.0f) {
    at.H[KC_STATE_X] = 1.0f;
  } else {
    at.H[KC_STATE_X] = ray.x / ray.length;
    at.H[KC_STATE_Y] = ray.y / ray.length;
    at.H[KC_STATE_Z] = ray.z / ray.length;
  }
  return at;
}

cf_linearization_t cf_linearize_tdoa(const float X[KC_STATE_DIM], const tdoaMeasurement_t *tdoa) {
  const point_t *anchors = tdoa->anchorPositions;
  const ray_t    a       = ray_to(X, anchors[0].x, anchors[0].y, anchors[0].z);
  const ray_t    b       = ray_to(X, anchors[1].x, anchors[1].y, anchors[1].z);

  cf_linearization_t at = {
      .error          = tdoa->distanceDiff - (b.length - a.length),
      .has_derivative = a.length != 0.0f && b.length != 0.0f,
  };

  // H = b / |b| - a / |a|
  if (at.has_derivative) {
    at.H[KC_STATE_X] = b.x / b.length - a.x / a.length;
    at.H[KC_STATE_Y] = b.y / b.length - a.y / a.length;
    at.H[KC_STATE_Z] = b.z / b.length - a.z / a.length;
  }
  return at;
}
