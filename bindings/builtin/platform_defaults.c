#include "builtin/platform_defaults.h"

#include <stddef.h>

// what the two airframes have in common
// clang-format off
#define SHARED_DEFAULTS                                             \
  .yaw_rate                  = {120.0f, 16.7f, 0.0f, 0.0f},         \
  .roll                      = {6.0f, 3.0f, 0.0f, 0.0f},            \
  .pitch                     = {6.0f, 3.0f, 0.0f, 0.0f},            \
  .yaw                       = {6.0f, 1.0f, 0.35f, 0.0f},           \
  .yaw_max_delta             = 0.0f,                                \
  .roll_rate_integral_limit  = 33.3f,                               \
  .pitch_rate_integral_limit = 33.3f,                               \
  .yaw_rate_integral_limit   = 166.7f,                              \
  .roll_integral_limit       = 20.0f,                               \
  .pitch_integral_limit      = 20.0f,                               \
  .yaw_integral_limit        = 360.0f,                              \
  .rate_filter_enabled       = false,                               \
  .roll_rate_cutoff          = 30.0f,                               \
  .pitch_rate_cutoff         = 30.0f,                               \
  .yaw_rate_cutoff           = 30.0f,                               \
  .attitude_filter           = {.enabled = false, .cutoff = 15.0f}, \
  .x                         = {2.0f, 0.0f, 0.0f, 0.0f},            \
  .y                         = {2.0f, 0.0f, 0.0f, 0.0f},            \
  .z                         = {2.0f, 0.5f, 0.0f, 0.0f},            \
  .vx                        = {25.0f, 1.0f, 0.0f, 0.0f},           \
  .vy                        = {25.0f, 1.0f, 0.0f, 0.0f},           \
  .vz                        = {25.0f, 15.0f, 0.0f, 0.0f},          \
  .position_xy_filter        = {.enabled = true, .cutoff = 20.0f},  \
  .position_z_filter         = {.enabled = true, .cutoff = 20.0f},  \
  .velocity_xy_filter        = {.enabled = true, .cutoff = 20.0f},  \
  .velocity_z_filter         = {.enabled = true, .cutoff = 20.0f},  \
  .roll_max                  = 20.0f,                               \
  .pitch_max                 = 20.0f,                               \
  .velocity_x_max            = 1.0f,                                \
  .velocity_y_max            = 1.0f,                                \
  .velocity_z_max            = 1.0f,                                \
  .thrust_min                = 20000
// clang-format on

static const cf_platform_defaults_t DEFAULTS[CF_PLATFORM_COUNT] = {
    [CF_PLATFORM_CF2] =
        {
            .roll_rate   = {250.0f, 500.0f, 2.5f, 0.0f},
            .pitch_rate  = {250.0f, 500.0f, 2.5f, 0.0f},
            .thrust_base = 36000,
            .idle_thrust = 0,
            SHARED_DEFAULTS,
        },
    [CF_PLATFORM_CF21BL] =
        {
            .roll_rate   = {200.0f, 400.0f, 2.5f, 0.0f},
            .pitch_rate  = {200.0f, 400.0f, 2.5f, 0.0f},
            .thrust_base = 30000,
            .idle_thrust = 7000,
            SHARED_DEFAULTS,
        },
};

const cf_platform_defaults_t *cf_platform_defaults(cf_platform_t platform) {
  if ((int)platform < 0 || platform >= CF_PLATFORM_COUNT) {
    return NULL;
  }
  return &DEFAULTS[platform];
}
