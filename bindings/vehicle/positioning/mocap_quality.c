#include "vehicle/positioning/mocap_quality.h"

#include <stddef.h>

// What differs from one quality to the next. The rest is common.
typedef struct {
  uint32_t                latency_ms;
  float                   position_noise;
  float                   attitude_noise;
  float                   position_std;
  float                   attitude_std;
  float                   outlier;
  cf_spell_config_t       gap;
  cf_mocap_shift_config_t jump;
  cf_mocap_shift_config_t swap;
  cf_spell_config_t       busy;
  uint32_t                busy_ms;
} differences_t;

static const differences_t DIFFERENCES[CF_MOCAP_QUALITY_COUNT] = {
    [CF_MOCAP_GOOD]    = {.latency_ms     = 8,
                          .position_noise = 0.001f,
                          .attitude_noise = 0.002f,
                          .position_std   = 0.003f,
                          .attitude_std   = 0.04f},
    [CF_MOCAP_TYPICAL] = {.latency_ms     = 12,
                          .position_noise = 0.001f,
                          .attitude_noise = 0.004f,
                          .position_std   = 0.0075f,
                          .attitude_std   = 0.06f,
                          .gap            = {.rate = 1.3f, .time = 0.045f},
                          .jump           = {{.rate = 0.5f, .time = 0.3f}, 0.004f, 0.03f},
                          .busy           = {.rate = 1.5f, .time = 0.25f},
                          .busy_ms        = 50},
    [CF_MOCAP_POOR]    = {.latency_ms     = 18,
                          .position_noise = 0.002f,
                          .attitude_noise = 0.008f,
                          .position_std   = 0.01f,
                          .attitude_std   = 0.06f,
                          .outlier        = 0.0005f,
                          .gap            = {.rate = 1.5f, .time = 0.15f},
                          .jump           = {{.rate = 0.7f, .time = 0.4f}, 0.008f, 0.05f},
                          .swap           = {{.rate = 0.05f, .time = 0.2f}, 0.03f, 0.3f},
                          .busy           = {.rate = 2.0f, .time = 0.3f},
                          .busy_ms        = 80},
};

cf_status_t cf_mocap_of_quality(cf_mocap_config_t *config, cf_mocap_quality_t quality) {
  if (quality < CF_MOCAP_GOOD || quality >= CF_MOCAP_QUALITY_COUNT) {
    return CF_ERR_UNKNOWN;
  }
  const differences_t *own = &DIFFERENCES[quality];
  *config                  = (cf_mocap_config_t){
      .rate           = 100,
      .latency_ms     = own->latency_ms,
      .position_noise = own->position_noise,
      .attitude_noise = own->attitude_noise,
      .position_std   = own->position_std,
      .attitude_std   = own->attitude_std,
      .mishap         = {.outlier = own->outlier, .outlier_size = 0.5f},
      .gap            = own->gap,
      .jump           = own->jump,
      .swap           = own->swap,
      .busy           = own->busy,
      .busy_ms        = own->busy_ms,
  };
  return CF_OK;
}
