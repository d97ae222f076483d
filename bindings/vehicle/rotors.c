#include "vehicle/rotors.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "vehicle/valid.h"

static const float TICK        = 0.001f;        // [s]
static const float RAD_PER_RPM = 0.104719755f;  // [rad/s per rpm]
static const float STOPPED_RPM = 1.0e-3f;       // below it the rotor stands still: no denormals
static const float COLD        = 1.0e-6f;       // warmth below which a motor is cold, likewise

// One number per rotor, in one vector register. The compiler does not find this by itself, and it
// makes the step three times faster (gcc and clang, any processor).
typedef float   lanes_t __attribute__((vector_size(16)));
typedef int32_t masks_t __attribute__((vector_size(16)));

static inline lanes_t every(float x) {
  return (lanes_t){x, x, x, x};
}

static inline lanes_t load(const float from[CF_ROTOR_COUNT]) {
  lanes_t lanes;
  memcpy(&lanes, from, sizeof lanes);
  return lanes;
}

static inline void store(float to[CF_ROTOR_COUNT], lanes_t lanes) {
  memcpy(to, &lanes, sizeof lanes);
}

static inline lanes_t root(lanes_t x) {
  return (lanes_t){sqrtf(x[0]), sqrtf(x[1]), sqrtf(x[2]), sqrtf(x[3])};
}

// x where it is above the limit, else `otherwise`
static inline lanes_t if_above(lanes_t x, lanes_t limit, lanes_t otherwise) {
  const masks_t above = x > limit;
  return (lanes_t)((above & (masks_t)x) | (~above & (masks_t)otherwise));
}

// F = c0 + c1 V + c2 V^2 + c3 V^3
static inline lanes_t thrust_curve(const cf_thrust_curve_t *curve, lanes_t voltage) {
  return curve->c0 + voltage * (curve->c1 + voltage * (curve->c2 + voltage * curve->c3));
}

static inline lanes_t steady_rpm(const cf_rotors_config_t *config, lanes_t voltage) {
  const float f1           = config->thrust_per_rpm;
  const float f2           = config->thrust_per_rpm2;
  const float low          = config->linear_voltage;
  const float half_inverse = 0.5f / f2;
  const float low_inverse  = 1.0f / low;

  // from `low` on the inverse of F = f1 n + f2 n^2
  const lanes_t upper  = if_above(voltage, every(low), every(low));
  const lanes_t force  = thrust_curve(&config->curve, upper);
  const lanes_t curved = (root(f1 * f1 + (4.0f * f2) * force) - f1) * half_inverse;

  // below it a line to zero
  const lanes_t share = voltage * low_inverse;
  return curved * -if_above(-share, every(-1.0f), every(-1.0f));
}

static inline lanes_t thrust_of(const cf_rotors_config_t *config, lanes_t rpm) {
  // f1 < 0 would pull down at the lowest speeds
  const lanes_t thrust = rpm * (config->thrust_per_rpm + rpm * config->thrust_per_rpm2);
  return if_above(thrust, every(0.0f), every(0.0f));
}

static bool is_curve_valid(const cf_rotors_config_t *config) {
  const cf_thrust_curve_t *curve = &config->curve;
  return cf_is_within(curve->c0, -1.0f, 1.0f) && cf_is_within(curve->c1, -1.0f, 1.0f) &&
         cf_is_within(curve->c2, -1.0f, 1.0f) && cf_is_within(curve->c3, -1.0f, 1.0f) &&
         cf_is_within(config->thrust_per_rpm, -1.0f, 1.0f) &&
         cf_is_positive(config->thrust_per_rpm2) && cf_is_not_negative(curve->thrust_to_torque) &&
         cf_is_positive(config->linear_voltage) &&
         // the square root of the steady speed exists from the linear voltage on
         thrust_curve(curve, every(config->linear_voltage))[0] >= 0.0f;
}

static bool is_body_valid(const cf_rotors_config_t *config) {
  return cf_is_positive(config->hover_rpm) && cf_is_positive(config->radius) &&
         cf_is_not_negative(config->inertia) && cf_is_positive(config->arm_x) &&
         cf_is_positive(config->arm_y) && cf_is_within(config->height, -1.0f, 1.0f);
}

static bool is_law_valid(const cf_rotors_config_t *config) {
  return config->law >= CF_ROTOR_FIRST_ORDER && config->law <= CF_ROTOR_QUADRATIC &&
         cf_is_positive(config->time_constant_up) && cf_is_positive(config->time_constant_down) &&
         cf_is_within(config->rate_up, 0.0f, 200.0f) &&
         cf_is_within(config->square_rate_up, 0.0f, 0.01f) &&
         cf_is_within(config->rate_down, 0.0f, 200.0f) &&
         cf_is_within(config->square_rate_down, 0.0f, 0.01f);
}

static bool is_heat_valid(const cf_rotors_config_t *config) {
  return cf_is_within(config->heat_loss, 0.0f, 0.5f) && cf_is_positive(config->heat_time) &&
         cf_is_within(config->heat_own_loss, 0.0f, 0.5f) && cf_is_positive(config->heat_own_time) &&
         cf_is_positive(config->heat_thrust);
}

static bool is_drive_valid(const cf_rotors_config_t *config) {
  bool has_efficiency = cf_is_within(config->thrust_scale, 0.0f, 2.0f);
  for (int i = 0; i < CF_ROTOR_COUNT; i++) {
    has_efficiency = has_efficiency && cf_is_within(config->efficiency[i], 0.0f, 2.0f);
  }
  return has_efficiency && config->duty_bits >= 1 && config->duty_bits <= 16 &&
         config->duty_lowest_level >= 0 && config->duty_lowest_level <= 65535;
}

static bool is_valid(const cf_rotors_config_t *config) {
  return is_curve_valid(config) && is_body_valid(config) && is_law_valid(config) &&
         is_heat_valid(config) && is_drive_valid(config);
}

cf_status_t cf_rotors_init(cf_rotors_t *rotors, const cf_rotors_config_t *config) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }

  const float hover_rpm = config->hover_rpm;

  *rotors = (cf_rotors_t){
      .config             = *config,
      .duty_per_level     = 1.0f / (float)((1 << config->duty_bits) - 1),
      .decay_up           = expf(-TICK / config->time_constant_up),
      .decay_down         = expf(-TICK / config->time_constant_down),
      .vibration_per_rpm2 = 1.0f / ((float)CF_ROTOR_COUNT * hover_rpm * hover_rpm),
      .has_heat           = config->heat_loss > 0.0f || config->heat_own_loss > 0.0f,
      .heat_rate          = 1.0f - expf(-TICK / config->heat_time),
      .heat_own_rate      = 1.0f - expf(-TICK / config->heat_own_time),
      .heat_per_thrust    = 1.0f / config->heat_thrust,
  };
  for (int i = 0; i < CF_ROTOR_COUNT; i++) {
    cf_rotors_set_efficiency(rotors, i, config->efficiency[i]);
  }
  return CF_OK;
}

cf_status_t cf_rotors_set_efficiency(cf_rotors_t *rotors, int motor, float efficiency) {
  if (motor < 0 || motor >= CF_ROTOR_COUNT) {
    return CF_ERR_CAPACITY;
  }
  if (!cf_is_within(efficiency, 0.0f, 2.0f)) {
    return CF_ERR_VALUE;
  }
  rotors->efficiency[motor] = efficiency;
  rotors->gain[motor]       = rotors->config.thrust_scale * efficiency;
  rotors->driven[motor]     = efficiency > 0.0f ? 1.0f : 0.0f;
  return CF_OK;
}

// Voltage at the motors: levels of the duty, times the pack.
static inline lanes_t motor_voltage(const cf_rotors_t *rotors,
                                    const uint16_t ratios[CF_ROTOR_COUNT], float pack_voltage) {
  const int     shift  = 16 - rotors->config.duty_bits;
  const masks_t levels = {ratios[0] >> shift, ratios[1] >> shift, ratios[2] >> shift,
                          ratios[3] >> shift};
  const masks_t kept   = levels & (levels >= rotors->config.duty_lowest_level);
  return __builtin_convertvector(kept, lanes_t) * (rotors->duty_per_level * pack_voltage);
}

static inline lanes_t choose(masks_t mask, lanes_t yes, lanes_t no) {
  return (lanes_t)((mask & (masks_t)yes) | (~mask & (masks_t)no));
}

// n = n_c + (n - n_c) exp(-h / tau), exact
static inline lanes_t first_order(const cf_rotors_t *rotors, lanes_t before, lanes_t target) {
  const lanes_t decay = choose(target > before, every(rotors->decay_up), every(rotors->decay_down));
  return target + (before - target) * decay;
}

// dn/dt = a (n_c - n) + b (n_c^2 - n^2), explicit: its fastest rates are far below 1 kHz
static inline lanes_t quadratic(const cf_rotors_config_t *config, lanes_t before, lanes_t target) {
  const masks_t is_up = target > before;
  const lanes_t a     = choose(is_up, every(config->rate_up), every(config->rate_down));
  const lanes_t b = choose(is_up, every(config->square_rate_up), every(config->square_rate_down));
  const lanes_t share = TICK * (a + b * (target + before));
  return before + (target - before) * choose(share > every(1.0f), every(1.0f), share);
}

static inline float mean_of(lanes_t x) {
  return 0.25f * ((x[0] + x[1]) + (x[2] + x[3]));
}

static inline float or_cold(float warmth) {
  return warmth > COLD ? warmth : 0.0f;
}

// Heats the motors for a tick; returns what they deliver of the thrust that they have when warm.
// The current of a motor goes with the thrust that it delivers, and its heat with the square of
// that: so a motor that fades gets no hotter by it.
static inline lanes_t fade(cf_rotors_t *rotors, lanes_t warm) {
  const cf_rotors_config_t *config = &rotors->config;

  const lanes_t own    = load(rotors->own_warmth);
  const float   common = 1.0f + config->heat_loss * (1.0f - rotors->warmth);
  // no motor is colder than cold
  const lanes_t colder = mean_of(own) - own;
  const lanes_t share =
      common - config->heat_own_loss * if_above(-colder, every(-1.0f), every(-1.0f));
  const lanes_t thrust = warm * if_above(share, every(0.0f), every(0.0f));

  const lanes_t current = rotors->heat_per_thrust * thrust;
  const lanes_t heat    = current * current;
  const lanes_t moved   = own + rotors->heat_own_rate * (heat - own);
  rotors->warmth = or_cold(rotors->warmth + rotors->heat_rate * (mean_of(heat) - rotors->warmth));
  store(rotors->own_warmth, if_above(moved, every(COLD), every(0.0f)));
  return thrust;
}

void cf_rotors_step(cf_rotors_t *rotors, const uint16_t ratios[CF_ROTOR_COUNT],
                    float pack_voltage) {
  const cf_rotors_config_t *config = &rotors->config;

  // speed
  const lanes_t voltage = motor_voltage(rotors, ratios, pack_voltage);
  const lanes_t target  = load(rotors->driven) * steady_rpm(config, voltage);
  const lanes_t before  = load(rotors->rpm);
  const lanes_t moved   = config->law == CF_ROTOR_FIRST_ORDER ? first_order(rotors, before, target)
                                                              : quadratic(config, before, target);
  const lanes_t rpm     = if_above(moved, every(STOPPED_RPM), every(0.0f));

  // what it does to the body
  const lanes_t warm    = load(rotors->gain) * thrust_of(config, rpm);
  const lanes_t thrust  = rotors->has_heat ? fade(rotors, warm) : warm;
  const lanes_t torque  = config->curve.thrust_to_torque * thrust;
  const lanes_t spin_up = (config->inertia * (RAD_PER_RPM / TICK)) * (rpm - before);
  const lanes_t squares = rpm * rpm;

  store(rotors->rpm, rpm);
  store(rotors->thrust, thrust);
  store(rotors->torque, torque);
  store(rotors->spin_up, spin_up);
  rotors->vibration =
      rotors->vibration_per_rpm2 * ((squares[0] + squares[1]) + (squares[2] + squares[3]));
}

float cf_rotors_total_thrust(const cf_rotors_t *rotors) {
  return (rotors->thrust[0] + rotors->thrust[1]) + (rotors->thrust[2] + rotors->thrust[3]);
}

float cf_rotor_steady_rpm(const cf_rotors_config_t *config, float voltage) {
  return voltage > 0.0f ? steady_rpm(config, every(voltage))[0] : 0.0f;
}

float cf_rotor_steady_thrust(const cf_rotors_config_t *config, float voltage) {
  return thrust_of(config, every(cf_rotor_steady_rpm(config, voltage)))[0];
}
