#include "deck_facts.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

float cf_range_std(float distance) {
  // sigma = A (1 + exp(k (d - a))), k = ln(B / A) / (b - a), A = 2.5 mm at a = 2.5 m, B = 0.2 m at
  // b = 4 m
  return 0.0025f * (1.0f + expf(2.92135109f * (distance - 2.5f)));
}

static const vec3d SENSORS[CF_LIGHTHOUSE_SENSORS] = {
    {-0.015f, 0.0075f, 0.0f},
    {-0.015f, -0.0075f, 0.0f},
    {0.015f, 0.0075f, 0.0f},
    {0.015f, -0.0075f, 0.0f},
};

const vec3d *cf_lighthouse_sensor_position(int sensor) {
  return sensor >= 0 && sensor < CF_LIGHTHOUSE_SENSORS ? &SENSORS[sensor] : NULL;
}

float cf_lighthouse_tilt(int sweep) {
  const float thirty_degrees = 3.14159265358979f / 6.0f;
  return sweep == 0 ? -thirty_degrees : thirty_degrees;
}

void cf_lighthouse_look_at(const float position[3], const float target[3], mat3d rotation) {
  float f[3];
  for (int i = 0; i < 3; i++) {
    f[i] = target[i] - position[i];
  }
  const float length = sqrtf(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  for (int i = 0; i < 3; i++) {
    f[i] /= length;
  }

  // left = up x front
  const float level = sqrtf(f[0] * f[0] + f[1] * f[1]);
  float       l[3]  = {0.0f, 1.0f, 0.0f};
  if (level > 1e-3f) {
    l[0] = -f[1] / level;
    l[1] = f[0] / level;
  }
  const float u[3] = {
      f[1] * l[2] - f[2] * l[1],
      f[2] * l[0] - f[0] * l[2],
      f[0] * l[1] - f[1] * l[0],
  };
  for (int i = 0; i < 3; i++) {
    rotation[i][0] = f[i];
    rotation[i][1] = l[i];
    rotation[i][2] = u[i];
  }
}
