/* Polynomials of degree 7 in one variable (docs/reference/planner-commander.md#4.2 to #4.4). */
#include <string.h>

#include "api/pptraj.h"

float polyval(const float p[PP_SIZE], float t) {
  float value = 0.0f;
  for (int k = PP_DEGREE; k >= 0; k--) {
    value = value * t + p[k];
  }
  return value;
}

void polylinear(float p[PP_SIZE], float duration, float x0, float x1) {
  memset(p, 0, PP_SIZE * sizeof p[0]);
  p[0] = x0;
  p[1] = (x1 - x0) / duration;
}

static float factorial(int n) {
  int product = 1;
  for (int i = 2; i <= n; i++) {
    product *= i;
  }
  return (float)product;
}

void polybezier(float p[PP_SIZE], float duration, const float *x, int dim) {
  if (dim <= 0) {
    return;
  }
  if (dim == 1) {
    p[0] = x[0];
    return;
  }
  if (dim == 2) {
    polylinear(p, duration, x[0], x[1]);
    return;
  }

  // p_j = n! / (n - j)! sum_i (-1)^(i + j) x_i / (i! (j - i)!) over the unit interval
  const int n = (dim < PP_SIZE ? dim : PP_SIZE) - 1;
  for (int j = 0; j <= n; j++) {
    float sum = 0.0f;
    for (int i = 0; i <= j; i++) {
      const float sign = (i + j) % 2 == 0 ? 1.0f : -1.0f;
      sum += sign * x[i] / factorial(i) / factorial(j - i);
    }
    p[j] = sum * factorial(n) / factorial(n - j);
  }
  polystretchtime(p, duration);
}

void poly5(float p[PP_SIZE], float T, float x0, float v0, float a0, float xf, float vf, float af) {
  const float T2 = T * T;
  const float T3 = T2 * T;
  const float T4 = T3 * T;
  const float T5 = T4 * T;
  p[0]           = x0;
  p[1]           = v0;
  p[2]           = a0 / 2.0f;
  p[3] = (-12.0f * v0 * T - 8.0f * vf * T - 3.0f * a0 * T2 + af * T2 - 20.0f * x0 + 20.0f * xf) /
         (2.0f * T3);
  p[4] = (16.0f * v0 * T + 14.0f * vf * T + 3.0f * a0 * T2 - 2.0f * af * T2 + 30.0f * x0 -
          30.0f * xf) /
         (2.0f * T4);
  p[5] =
      (-6.0f * v0 * T - 6.0f * vf * T - a0 * T2 + af * T2 - 12.0f * x0 + 12.0f * xf) / (2.0f * T5);
  p[6] = 0.0f;
  p[7] = 0.0f;
}

void polyscale(float p[PP_SIZE], float s) {
  for (int k = 0; k < PP_SIZE; k++) {
    p[k] *= s;
  }
}

void polyder(float p[PP_SIZE]) {
  for (int k = 1; k <= PP_DEGREE; k++) {
    p[k - 1] = (float)k * p[k];
  }
  p[PP_DEGREE] = 0.0f;
}

void polystretchtime(float p[PP_SIZE], float s) {
  const float recip = 1.0f / s;
  float       scale = recip;
  for (int k = 1; k < PP_SIZE; k++) {
    p[k] *= scale;
    scale *= recip;
  }
}

void polyreflect(float p[PP_SIZE]) {
  for (int k = 1; k < PP_SIZE; k += 2) {
    p[k] = -p[k];
  }
}
