#include "vehicle/positioning/mocap.h"

#include <math.h>
#include <string.h>

#include "vehicle/random_inline.h"
#include "vehicle/valid.h"

#define TICKS_PER_SECOND 1000u

static const float    LARGEST_SHIFT = 10.0f;  // [m]
static const float    LARGEST_TURN  = 3.2f;   // [rad]
static const uint32_t LONGEST_EXTRA = 1000;   // [ms]

static bool is_valid_shift(const cf_mocap_shift_config_t *config) {
  return cf_spell_check(&config->spell) == CF_OK &&
         cf_is_within(config->size, 0.0f, LARGEST_SHIFT) &&
         cf_is_within(config->angle, 0.0f, LARGEST_TURN);
}

static bool is_valid(const cf_mocap_config_t *config) {
  return config->rate <= TICKS_PER_SECOND && cf_is_not_negative(config->position_noise) &&
         cf_is_not_negative(config->attitude_noise) && cf_is_positive(config->position_std) &&
         cf_is_positive(config->attitude_std) && cf_mishap_check(&config->mishap) == CF_OK &&
         cf_spell_check(&config->gap) == CF_OK && is_valid_shift(&config->jump) &&
         is_valid_shift(&config->swap) && cf_spell_check(&config->busy) == CF_OK &&
         config->busy_ms <= LONGEST_EXTRA;
}

// A sample waits over latency + 1 steps; 64 bits, because the latency may be any number.
static bool fits(uint32_t rate, uint32_t latency_ms) {
  const uint64_t steps = (uint64_t)latency_ms + 1;
  return steps * rate <= (uint64_t)CF_MOCAP_CAPACITY * TICKS_PER_SECOND;
}

cf_status_t cf_mocap_init(cf_mocap_t *mocap, const cf_mocap_config_t *config, cf_random_t random,
                          cf_random_t mishap_random) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }
  if (!fits(config->rate, config->latency_ms)) {
    return CF_ERR_CAPACITY;
  }

  *mocap = (cf_mocap_t){
      .config        = *config,
      .phase         = (TICKS_PER_SECOND - config->rate) % TICKS_PER_SECOND,
      .random        = random,
      .mishap_random = mishap_random,
  };
  return CF_OK;
}

cf_status_t cf_mocap_set_latency(cf_mocap_t *mocap, uint32_t latency_ms) {
  if (!fits(mocap->config.rate, latency_ms)) {
    return CF_ERR_CAPACITY;
  }
  mocap->config.latency_ms = latency_ms;
  return CF_OK;
}

// q <- q (1, d/2), normalized, for a rotation d [rad] about body axes: small, or roughly.
static void rotate_slightly(float q[4], const float d[3]) {
  const float x = 0.5f * d[0];
  const float y = 0.5f * d[1];
  const float z = 0.5f * d[2];
  const float a = q[0], b = q[1], c = q[2], e = q[3];

  const float s = 1.0f / sqrtf(1.0f + x * x + y * y + z * z);
  q[0]          = s * (a - b * x - c * y - e * z);
  q[1]          = s * (b + a * x + c * z - e * y);
  q[2]          = s * (c + a * y + e * x - b * z);
  q[3]          = s * (e + a * z + b * y - c * x);
}

// A vector of this length in a random direction.
static void draw_direction(cf_random_t *random, float length, float vector[3]) {
  cf_random_normals(random, vector, 3);
  const float scale =
      length / sqrtf(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
  for (int i = 0; i < 3; i++) {
    vector[i] *= scale;
  }
}

// A wrong marker: off in a direction of its own.
static void misplace(cf_mocap_t *mocap, float position[3]) {
  const float error = cf_mishap_error(&mocap->config.mishap, &mocap->mishap_random);
  if (error == 0.0f) {
    return;
  }
  float shift[3];
  draw_direction(&mocap->mishap_random, error, shift);
  for (int i = 0; i < 3; i++) {
    position[i] += shift[i];
  }
}

// ---------------------------------------------------------------------------------------- spells

static void step_shift(cf_mocap_t *mocap, const cf_mocap_shift_config_t *config,
                       cf_mocap_shift_t *shift) {
  if (cf_spell_step(&config->spell, mocap->config.rate, &shift->left, &mocap->mishap_random)) {
    draw_direction(&mocap->mishap_random, config->size, shift->position);
    draw_direction(&mocap->mishap_random, config->angle, shift->turn);
  }
}

// Advances all spells by a frame, whether the drone is seen or not.
static void step_spells(cf_mocap_t *mocap) {
  const cf_mocap_config_t *config = &mocap->config;
  cf_spell_step(&config->gap, config->rate, &mocap->gap_left, &mocap->mishap_random);
  step_shift(mocap, &config->jump, &mocap->jump);
  step_shift(mocap, &config->swap, &mocap->swap);
  if (cf_spell_step(&config->busy, config->rate, &mocap->busy_left, &mocap->mishap_random)) {
    const float share = cf_random_uniform(&mocap->mishap_random);
    mocap->extra_ms   = (uint32_t)(share * (float)(config->busy_ms + 1u));
  }
}

static void apply_shift(const cf_mocap_shift_t *shift, cf_mocap_sample_t *sample) {
  if (shift->left == 0) {
    return;
  }
  for (int i = 0; i < 3; i++) {
    sample->position[i] += shift->position[i];
  }
  rotate_slightly(sample->quat_wxyz, shift->turn);
}

// --------------------------------------------------------------------------------------- samples

static void take_sample(cf_mocap_t *mocap, const float position[3], const float quat_wxyz[4]) {
  // drawn even when nothing is seen, so that a loss does not change the noise after it
  float normal[6];
  cf_next_normals(&mocap->random, normal, 6);
  step_spells(mocap);
  // behind a longer latency the ring may still be full
  if (mocap->is_lost || mocap->gap_left > 0 || mocap->waiting == CF_MOCAP_CAPACITY ||
      cf_mishap_drops(&mocap->config.mishap, &mocap->mishap_random)) {
    return;
  }

  const uint32_t     place  = (mocap->oldest + mocap->waiting) % CF_MOCAP_CAPACITY;
  cf_mocap_sample_t *sample = &mocap->samples[place];
  float              turn[3];
  for (int i = 0; i < 3; i++) {
    sample->position[i] = position[i] + mocap->config.position_noise * normal[i];
    turn[i]             = mocap->config.attitude_noise * normal[i + 3];
  }
  misplace(mocap, sample->position);
  memcpy(sample->quat_wxyz, quat_wxyz, sizeof sample->quat_wxyz);
  rotate_slightly(sample->quat_wxyz, turn);
  apply_shift(&mocap->jump, sample);
  apply_shift(&mocap->swap, sample);
  sample->due =
      mocap->tick + mocap->config.latency_ms + (mocap->busy_left > 0 ? mocap->extra_ms : 0);
  mocap->waiting++;
}

static poseMeasurement_t pose_of(const cf_mocap_config_t *config, const cf_mocap_sample_t *sample) {
  const float *q = sample->quat_wxyz;
  return (poseMeasurement_t){
      .pos        = {sample->position[0], sample->position[1], sample->position[2]},
      .quat       = {.x = q[1], .y = q[2], .z = q[3], .w = q[0]},
      .stdDevPos  = config->position_std,
      .stdDevQuat = config->attitude_std,
  };
}

// Compares ticks that may have wrapped. A pose that is overdue was queued behind an earlier pose.
static bool is_over(uint32_t due, uint32_t tick) {
  return (int32_t)(tick - due) >= 0;
}

bool cf_mocap_step(cf_mocap_t *mocap, const float position[3], const float quat_wxyz[4],
                   poseMeasurement_t *pose) {
  // cameras
  mocap->phase += mocap->config.rate;
  if (mocap->phase >= TICKS_PER_SECOND) {
    mocap->phase -= TICKS_PER_SECOND;
    take_sample(mocap, position, quat_wxyz);
  }

  // radio
  const cf_mocap_sample_t *oldest  = &mocap->samples[mocap->oldest];
  const bool               arrives = mocap->waiting > 0 && is_over(oldest->due, mocap->tick);
  if (arrives) {
    *pose         = pose_of(&mocap->config, oldest);
    mocap->oldest = (mocap->oldest + 1) % CF_MOCAP_CAPACITY;
    mocap->waiting--;
  }
  mocap->tick++;
  return arrives;
}
