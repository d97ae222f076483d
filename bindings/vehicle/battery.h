/* One lithium-polymer cell: open-circuit voltage, sag under load, charge left.
 *
 *   V = OCV(charge) - I R0 - v1,  dv1/dt = (I R1 - v1) / T1,  I = P / V
 *
 * with the power P that the electronics and the rotors draw (docs/reference/vehicle.md#6). Below
 * zero charge the open-circuit voltage falls from 3.2 to 2.2 V within a twentieth of the capacity,
 * so that an exhausted drone comes down. */
#ifndef CF_VEHICLE_BATTERY_H
#define CF_VEHICLE_BATTERY_H

#include <stdint.h>

#include "status.h"

typedef struct {
  float capacity;          // [C] > 0, 3.6 C per mAh
  float resistance;        // [Ohm] >= 0, R0: sag at once
  float slow_resistance;   // [Ohm] >= 0, R1: sag that builds up
  float slow_time;         // [s] > 0, T1
  float base_power;        // [W] >= 0, electronics
  float power_per_thrust;  // [W/N] >= 0

  float initial_charge;    // [0, 1]
  float constant_voltage;  // [V] in [0, 20]; above 0 a bench supply replaces the cell
} cf_battery_config_t;

typedef struct {
  cf_battery_config_t config;

  // state
  float    charge;        // [-0.05, 1], 1 = full
  float    drawn;         // [C], not yet taken from the charge
  float    slow_sag;      // [V], v1
  float    open_circuit;  // [V], at this charge
  uint32_t countdown;     // [ticks] to the next update of the charge

  // outputs
  float voltage;  // [V], at the terminals
  float current;  // [A]
} cf_battery_t;

// Fills the battery, loaded by its electronics only. Returns CF_ERR_VALUE when a number of the
// config is outside its range.
cf_status_t cf_battery_init(cf_battery_t *battery, const cf_battery_config_t *config);

// Sets the state of charge [0, 1]. Returns CF_ERR_VALUE for another.
cf_status_t cf_battery_set_charge(cf_battery_t *battery, float charge);

// Feeds a total thrust [N] for 1 ms.
void cf_battery_step(cf_battery_t *battery, float thrust);

// Pure: open-circuit voltage [V] of a cell at a charge, which is clipped to [-0.05, 1].
float cf_open_circuit_voltage(float charge);

#endif  // CF_VEHICLE_BATTERY_H
