/* What the onboard software knows of its battery: state of charge in words and in tenths.
 *
 * Limits: docs/reference/control-pid.md#12. The meaning of the numbers of pm.state:
 * docs/reference/crtp-cflib.md#20.1. How the level is read off the voltage is not established; here
 * it is the open-circuit curve of a generic cell (docs/reference/vehicle.md#6), so that a loaded
 * battery reads lower. */
#ifndef CF_ONBOARD_POWER_MANAGEMENT_H
#define CF_ONBOARD_POWER_MANAGEMENT_H

#include <stdint.h>

#include "platform.h"
#include "variables.h"

// Values of pm.state that a flying drone can have.
#define CF_POWER_BATTERY 0
#define CF_POWER_LOW 3

typedef struct {
  // parameters
  float low_voltage;           // [V], pm.lowVoltage
  float critical_low_voltage;  // [V], pm.criticalLowVoltage; for clients, nothing here acts on it

  // logs
  float    voltage;    // [V], pm.vbat
  uint16_t millivolt;  // pm.vbatMV
  int8_t   state;      // pm.state
  uint8_t  level;      // [%], pm.batteryLevel, in steps of 10

  uint32_t last_good_tick;  // [ms], when the voltage was last above low_voltage
} cf_power_management_t;

void cf_power_management_init(cf_power_management_t *power, cf_platform_t platform);

// Takes a measured voltage [V]; every tick.
void cf_power_management_measure(cf_power_management_t *power, float voltage);

// Judges the latest voltage. The battery is low when the voltage has not been above the limit for 5
// s.
void cf_power_management_update(cf_power_management_t *power, uint32_t tick);

cf_variables_t cf_power_management_parameters(void);
cf_variables_t cf_power_management_logs(void);

#endif  // CF_ONBOARD_POWER_MANAGEMENT_H
