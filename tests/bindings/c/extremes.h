/* Numbers that break things, and what flows through the controllers made of them. */
#ifndef CF_TEST_EXTREMES_H
#define CF_TEST_EXTREMES_H

#include <math.h>
#include <stdint.h>

#include "api/stabilizer_types.h"

static const float EXTREMES[] = {
    0.0f,          -0.0f,         1.0f,           -1.0f,          180.0f,   -180.0f,
    540.0f,        32767.0f,      -32768.0f,      65535.0f,       65536.0f, 16777216.0f,
    2147483520.0f, 2147483648.0f, -2147483648.0f, -2147483904.0f, 1e-45f,   1e20f,
    3.4e38f,       -3.4e38f,      INFINITY,       -INFINITY,      NAN,
};
#define EXTREME_COUNT ((int)(sizeof(EXTREMES) / sizeof(EXTREMES[0])))

// a small generator, so that the test needs no clock and no library
static inline uint32_t next_random(uint32_t *seed) {
  *seed = *seed * 1664525u + 1013904223u;
  return *seed >> 8;
}

static inline float random_extreme(uint32_t *seed) {
  return EXTREMES[next_random(seed) % (uint32_t)EXTREME_COUNT];
}

static inline Axis3f random_axes(uint32_t *seed) {
  return (Axis3f){.axis = {random_extreme(seed), random_extreme(seed), random_extreme(seed)}};
}

static inline attitude_t random_attitude(uint32_t *seed) {
  return (attitude_t){
      .roll = random_extreme(seed), .pitch = random_extreme(seed), .yaw = random_extreme(seed)};
}

static inline vector_t random_vector(uint32_t *seed) {
  return (vector_t){
      .x = random_extreme(seed), .y = random_extreme(seed), .z = random_extreme(seed)};
}

static inline quaternion_t random_quaternion(uint32_t *seed) {
  return (quaternion_t){.x = random_extreme(seed),
                        .y = random_extreme(seed),
                        .z = random_extreme(seed),
                        .w = random_extreme(seed)};
}

static inline setpoint_t random_setpoint(uint32_t *seed) {
  setpoint_t setpoint = {
      .attitude           = random_attitude(seed),
      .attitudeRate       = random_attitude(seed),
      .attitudeQuaternion = random_quaternion(seed),
      .thrust             = random_extreme(seed),
      .position           = random_vector(seed),
      .velocity           = random_vector(seed),
      .acceleration       = random_vector(seed),
      .jerk               = random_vector(seed),
      .velocity_body      = next_random(seed) % 2u == 0u,
  };
  setpoint.mode.x     = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.y     = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.z     = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.roll  = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.pitch = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.yaw   = (stab_mode_t)(next_random(seed) % 3u);
  setpoint.mode.quat  = (stab_mode_t)(next_random(seed) % 3u);
  return setpoint;
}

static inline state_t random_state(uint32_t *seed) {
  return (state_t){.attitude           = random_attitude(seed),
                   .attitudeQuaternion = random_quaternion(seed),
                   .position           = random_vector(seed),
                   .velocity           = random_vector(seed)};
}

#endif  // CF_TEST_EXTREMES_H
