#include "barriers.h"

#include <math.h>
#include <stddef.h>

static void find_motion(const double *own_position, const double *own_velocity,
                        const double *position, const double *velocity, double *offset,
                        double *closing) {
  for (int k = 0; k < 2; k++) {
    offset[k]  = own_position[k] - position[k];
    closing[k] = own_velocity[k] - velocity[k];
  }
  if (isnan(offset[0]) || isnan(offset[1])) {
    offset[0]  = INFINITY;
    offset[1]  = 0.0;
    closing[0] = closing[1] = 0.0;
  } else if (isnan(closing[0]) || isnan(closing[1])) {
    closing[0] = closing[1] = 0.0;
  }
}

void cf_relative_motion(int agents, int near, int axes, const double *own_positions,
                        const double *own_velocities, const double *positions,
                        const double *velocities, double *offsets, double *closings) {
  for (int i = 0; i < agents; i++) {
    for (int k = 0; k < near; k++) {
      const ptrdiff_t pair = (ptrdiff_t)i * near + k, own = (ptrdiff_t)i * axes;
      find_motion(own_positions + own, own_velocities + own, positions + pair * axes,
                  velocities + pair * axes, offsets + 2 * pair, closings + 2 * pair);
    }
  }
}

void cf_acceleration_barriers(int count, const double *offsets, const double *closings,
                              const cf_acceleration_barrier_t *barrier, double *normals,
                              double *sides, double *barriers) {
  for (int i = 0; i < count; i++, offsets += 2, closings += 2, normals += 2) {
    const double length = sqrt(offsets[0] * offsets[0] + offsets[1] * offsets[1]);
    if (isinf(length)) {
      normals[0] = normals[1] = 0.0;
      sides[i] = barriers[i] = INFINITY;
      continue;
    }
    const double x  = length == 0.0 ? 0.0 : offsets[0] / length;
    const double y  = length == 0.0 ? 0.0 : offsets[1] / length;
    const double vx = closings[0], vy = closings[1];
    const double approach = x * vx + y * vy;  // how fast the distance grows
    const double stopping = sqrt(barrier->braking * fmax(length - barrier->distance, 0.0));
    const double h        = approach + stopping;
    const double across   = (vx * vx + vy * vy - approach * approach) / length;
    const double slowing  = barrier->braking * approach / (2.0 * stopping) * barrier->slowing;
    normals[0]            = -x;
    normals[1]            = -y;
    barriers[i]           = h;
    sides[i] =
        length <= barrier->distance ? 0.0 : 0.5 * (barrier->gamma * (h * h * h) + across + slowing);
  }
}
