/* Gains and limits with which a platform boots (docs/reference/control-pid.md#12).
 *
 * What the airframe itself is (mass, arm, thrust curve) stands in platform.h. */
#ifndef CF_BUILTIN_PLATFORM_DEFAULTS_H
#define CF_BUILTIN_PLATFORM_DEFAULTS_H

#include <stdbool.h>
#include <stdint.h>

#include "platform.h"

typedef struct {
  float kp;
  float ki;
  float kd;
  float kff;
} cf_pid_gains_t;

// Low-pass on the derivative of a PID.
typedef struct {
  bool  enabled;
  float cutoff;  // [Hz]
} cf_pid_filter_t;

typedef struct {
  // attitude: deg/s -> actuator counts, deg -> deg/s
  cf_pid_gains_t roll_rate;
  cf_pid_gains_t pitch_rate;
  cf_pid_gains_t yaw_rate;
  cf_pid_gains_t roll;
  cf_pid_gains_t pitch;
  cf_pid_gains_t yaw;
  float          yaw_max_delta;  // [deg], how far the yaw target may run ahead; 0 for no bound

  // bounds of the integral of the error; the position loops keep the one of pidInit()
  float roll_rate_integral_limit;   // [deg]
  float pitch_rate_integral_limit;  // [deg]
  float yaw_rate_integral_limit;    // [deg]
  float roll_integral_limit;        // [deg s]
  float pitch_integral_limit;       // [deg s]
  float yaw_integral_limit;         // [deg s]

  bool  rate_filter_enabled;
  float roll_rate_cutoff;   // [Hz]
  float pitch_rate_cutoff;  // [Hz]
  float yaw_rate_cutoff;    // [Hz]

  cf_pid_filter_t attitude_filter;

  // position: m -> m/s, m/s -> deg (x, y) or thousands of counts (z)
  cf_pid_gains_t x;
  cf_pid_gains_t y;
  cf_pid_gains_t z;
  cf_pid_gains_t vx;
  cf_pid_gains_t vy;
  cf_pid_gains_t vz;

  cf_pid_filter_t position_xy_filter;
  cf_pid_filter_t position_z_filter;
  cf_pid_filter_t velocity_xy_filter;
  cf_pid_filter_t velocity_z_filter;

  float    roll_max;        // [deg]
  float    pitch_max;       // [deg]
  float    velocity_x_max;  // [m/s]
  float    velocity_y_max;  // [m/s]
  float    velocity_z_max;  // [m/s]
  uint16_t thrust_base;     // guess of the hover thrust [counts]
  uint16_t thrust_min;      // [counts]

  uint32_t idle_thrust;  // duty of an armed motor at rest [counts]
} cf_platform_defaults_t;

// Returns the defaults of a platform, or null for an unknown number.
const cf_platform_defaults_t *cf_platform_defaults(cf_platform_t platform);

#endif  // CF_BUILTIN_PLATFORM_DEFAULTS_H
