#include "onboard/decks/lighthouse_geometry.h"

#include <math.h>

#define SHORTEST_BASELINE 1e-4f  // [m]
#define LARGEST_MISS 0.05f       // [m], between two rays that cross

float cf_dot3(const float a[3], const float b[3]) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void cross(const float a[3], const float b[3], float out[3]) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

bool cf_lighthouse_yaw_delta(const float n[3], const float ipv[3], const float spv[3],
                             float *delta) {
  const float length = sqrtf(cf_dot3(ipv, ipv));
  if (!(length >= SHORTEST_BASELINE)) {
    return false;
  }
  const float cosine  = cf_dot3(spv, ipv) / (sqrtf(cf_dot3(spv, spv)) * length);
  const float clipped = cosine > 1.0f ? 1.0f : (cosine < -1.0f ? -1.0f : cosine);
  float       turn[3];
  cross(spv, ipv, turn);
  *delta = cf_dot3(n, turn) > 0.0f ? -acosf(clipped) : acosf(clipped);
  return true;
}

bool cf_lighthouse_cross(const float p0[3], const float d0[3], const float p1[3], const float d1[3],
                         float middle[3]) {
  // minimize |p0 + s d0 - p1 - t d1|^2
  const float w[3] = {p0[0] - p1[0], p0[1] - p1[1], p0[2] - p1[2]};
  const float a = cf_dot3(d0, d0), b = cf_dot3(d0, d1), c = cf_dot3(d1, d1);
  const float d = cf_dot3(d0, w), e = cf_dot3(d1, w);
  const float determinant = a * c - b * b;
  if (!(determinant > 1e-4f * a * c)) {
    return false;
  }
  const float s = (b * e - c * d) / determinant;
  const float t = (a * e - b * d) / determinant;
  float       miss[3];
  for (int i = 0; i < 3; i++) {
    const float on0 = p0[i] + s * d0[i];
    const float on1 = p1[i] + t * d1[i];
    middle[i]       = 0.5f * (on0 + on1);
    miss[i]         = on0 - on1;
  }
  return cf_dot3(miss, miss) < LARGEST_MISS * LARGEST_MISS;
}

float cf_median(float *numbers, int count) {
  for (int i = 1; i < count; i++) {
    for (int k = i; k > 0 && numbers[k - 1] > numbers[k]; k--) {
      const float swap = numbers[k];
      numbers[k]       = numbers[k - 1];
      numbers[k - 1]   = swap;
    }
  }
  return 0.5f * (numbers[(count - 1) / 2] + numbers[count / 2]);
}
