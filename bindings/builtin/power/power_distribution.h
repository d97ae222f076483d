/* From the controller's output to four motors: mixer, battery compensation, cap
 * (docs/reference/control-pid.md#13 and #14).
 *
 * M1 front right, M2 back right, M3 back left, M4 front left. Counts run from 0 to 65535 and mean
 * thrust before compensation, duty after it. Fractions are cut towards zero; a number too large for
 * its integer saturates and NaN becomes 0, as the vehicle's processor does it. */
#ifndef CF_BUILTIN_POWER_POWER_DISTRIBUTION_H
#define CF_BUILTIN_POWER_POWER_DISTRIBUTION_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

typedef struct {
  // facts about the platform
  float             arm_length;  // [m]
  cf_thrust_curve_t thrust;
  bool              requires_arming;

  // parameter
  uint32_t idle_thrust;  // [counts], of which a motor gets the low 16 bits

  // the last command of each motor and the voltage solved for it: commands change every second tick
  int32_t solved_command[4];  // [counts]
  float   solved_voltage[4];  // [V]
} cf_power_distribution_t;

// Writes the whole struct. Returns CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_power_distribution_init(cf_power_distribution_t *power, cf_platform_t platform);

// Mixes. An unknown control mode leaves `uncapped` as it is.
void cf_power_distribution_update(const cf_power_distribution_t *power, const control_t *control,
                                  motors_thrust_uncapped_t *uncapped);

// Turns thrust into duty for a supply [V]; the same numbers as cf_battery_compensate().
void cf_power_distribution_compensate(cf_power_distribution_t        *power,
                                      const motors_thrust_uncapped_t *uncapped,
                                      float supply_voltage, motors_thrust_uncapped_t *compensated);

// Fits the duties into [idle thrust, 65535]: what is above the top is taken from all four motors.
// Returns whether that was necessary.
bool cf_power_distribution_cap(const cf_power_distribution_t  *power,
                               const motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *pwm);

// Returns the lowest duty [counts] of a running motor: 0 unless the platform requires arming.
uint32_t cf_power_distribution_idle_thrust(const cf_power_distribution_t *power);

// Returns the largest thrust of the four motors together [N].
float cf_power_distribution_max_thrust(const cf_power_distribution_t *power);

// Table of powerDist, offsets relative to cf_power_distribution_t.
cf_variables_t cf_power_distribution_parameters(void);

#endif  // CF_BUILTIN_POWER_POWER_DISTRIBUTION_H
