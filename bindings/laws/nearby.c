#include "nearby.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static double distance_of(const double *one, const double *other) {
  return hypot(one[0] - other[0], one[1] - other[1]);
}

// Inserts an agent behind those that are as near, or nearer.
static void insert(int agent, double distance, int count, int32_t *row, double *distances) {
  int low = 0, high = count;
  while (low < high) {
    const int middle = (low + high) / 2;
    if (distances[middle] > distance) {
      high = middle;
    } else {
      low = middle + 1;
    }
  }
  const size_t farther = (size_t)(count - low);
  memmove(row + low + 1, row + low, farther * sizeof *row);
  memmove(distances + low + 1, distances + low, farther * sizeof *distances);
  row[low]       = agent;
  distances[low] = distance;
}

int cf_find_nearby(int agents, int axes, const double *positions, double distance, double *scratch,
                   int32_t *table) {
  int most = 0;
  for (int i = 0; i < agents; i++) {
    const double *own   = positions + (ptrdiff_t)i * axes;
    int32_t      *row   = table + (ptrdiff_t)i * (agents - 1);
    int           count = 0;
    for (int k = 0; k < agents; k++) {
      const double away = distance_of(own, positions + (ptrdiff_t)k * axes);
      // false for NaN
      if (k != i && away < distance) {
        insert(k, away, count++, row, scratch);
      }
    }
    for (int k = count; k < agents - 1; k++) {
      row[k] = -1;
    }
    most = count > most ? count : most;
  }
  return most;
}

void cf_gather_nearby(int agents, int axes, const double *vectors, const int32_t *table, int width,
                      int near, double *gathered) {
  for (int i = 0; i < agents; i++) {
    for (int k = 0; k < near; k++) {
      const int32_t other = table[(ptrdiff_t)i * width + k];
      for (int a = 0; a < axes; a++) {
        *gathered++ = other < 0 ? (double)NAN : vectors[(ptrdiff_t)other * axes + a];
      }
    }
  }
}
