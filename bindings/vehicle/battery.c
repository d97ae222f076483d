#include "vehicle/battery.h"

#include <stdbool.h>

#include "vehicle/valid.h"

// The charge moves in steps of 0.1 s: one step of 1 ms would drown in the rounding of a float.
#define CHARGE_TICKS 100

// Open-circuit voltage [V] every 0.05 of charge from -0.2 to 1 (docs/reference/vehicle.md#6; values
// between its rows continue its lines). An empty cell collapses: what it gives beyond its capacity
// is a twentieth of it.
#define KNOTS_PER_CHARGE 20.0f
#define FIRST_KNOT -0.2f
#define LOWEST_CHARGE -0.05f
#define KNOT_COUNT 25
static const float OPEN_CIRCUIT[KNOT_COUNT] = {
    2.20f,  2.20f, 2.20f, 2.20f, 3.20f, 3.45f, 3.62f, 3.66f, 3.70f, 3.72f, 3.74f, 3.755f, 3.77f,
    3.785f, 3.80f, 3.82f, 3.84f, 3.87f, 3.90f, 3.94f, 3.98f, 4.03f, 4.08f, 4.14f, 4.20f,
};

static const float TICK           = 0.001f;  // [s]
static const float LOWEST_VOLTAGE = 0.5f;    // [V], keeps the current finite

float cf_open_circuit_voltage(float charge) {
  const float clipped  = charge > LOWEST_CHARGE ? (charge < 1.0f ? charge : 1.0f) : LOWEST_CHARGE;
  const float place    = (clipped - FIRST_KNOT) * KNOTS_PER_CHARGE;
  const int   knot     = place < (float)(KNOT_COUNT - 2) ? (int)place : KNOT_COUNT - 2;
  const float fraction = place - (float)knot;
  return OPEN_CIRCUIT[knot] + fraction * (OPEN_CIRCUIT[knot + 1] - OPEN_CIRCUIT[knot]);
}

// V = OCV - I R0 - v1
static float terminal_voltage(const cf_battery_t *battery) {
  const float voltage =
      battery->open_circuit - battery->current * battery->config.resistance - battery->slow_sag;
  return voltage > LOWEST_VOLTAGE ? voltage : LOWEST_VOLTAGE;
}

static bool is_valid(const cf_battery_config_t *config) {
  return cf_is_positive(config->capacity) && cf_is_not_negative(config->resistance) &&
         cf_is_not_negative(config->slow_resistance) && cf_is_positive(config->slow_time) &&
         cf_is_not_negative(config->base_power) && cf_is_not_negative(config->power_per_thrust) &&
         cf_is_within(config->initial_charge, 0.0f, 1.0f) &&
         cf_is_within(config->constant_voltage, 0.0f, 20.0f);
}

cf_status_t cf_battery_init(cf_battery_t *battery, const cf_battery_config_t *config) {
  if (!is_valid(config)) {
    return CF_ERR_VALUE;
  }

  const bool  is_supply    = config->constant_voltage > 0.0f;
  const float open_circuit = cf_open_circuit_voltage(config->initial_charge);

  *battery = (cf_battery_t){
      .config       = *config,
      .charge       = config->initial_charge,
      .open_circuit = open_circuit,
      .countdown    = CHARGE_TICKS,
      .voltage      = config->constant_voltage,
      .current      = config->base_power / (is_supply ? config->constant_voltage : open_circuit),
  };
  if (!is_supply) {
    battery->voltage = terminal_voltage(battery);
  }
  return CF_OK;
}

cf_status_t cf_battery_set_charge(cf_battery_t *battery, float charge) {
  if (!cf_is_within(charge, 0.0f, 1.0f)) {
    return CF_ERR_VALUE;
  }
  battery->charge       = charge;
  battery->drawn        = 0.0f;
  battery->open_circuit = cf_open_circuit_voltage(charge);
  return CF_OK;
}

void cf_battery_step(cf_battery_t *battery, float thrust) {
  const cf_battery_config_t *config = &battery->config;

  // I = P / V with the voltage of the last tick
  const float power = config->base_power + config->power_per_thrust * thrust;
  battery->current  = power / battery->voltage;
  if (config->constant_voltage > 0.0f) {
    return;
  }

  // charge and what depends on it alone, now and then
  battery->drawn += battery->current * TICK;
  if (--battery->countdown == 0) {
    const float charge    = battery->charge - battery->drawn / config->capacity;
    battery->charge       = charge > LOWEST_CHARGE ? charge : LOWEST_CHARGE;
    battery->open_circuit = cf_open_circuit_voltage(battery->charge);
    battery->drawn        = 0.0f;
    battery->countdown    = CHARGE_TICKS;
  }

  // dv1/dt = (I R1 - v1) / T1
  const float target = battery->current * config->slow_resistance;
  battery->slow_sag += (target - battery->slow_sag) * (TICK / config->slow_time);
  battery->voltage = terminal_voltage(battery);
}
