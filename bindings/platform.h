/* Airframes, and the facts about them that the onboard software and the plant must agree on.
 *
 * Source: docs/reference/control-pid.md#12, "Physical constants"; docs/reference/vehicle.md#3. */
#ifndef CF_PLATFORM_H
#define CF_PLATFORM_H

#include <stdbool.h>

#include "status.h"

typedef enum {
  CF_PLATFORM_CF2    = 0,  // Crazyflie 2.0, 2.1 and 2.1+, brushed, 2.1+ propellers
  CF_PLATFORM_CF21BL = 1,  // Crazyflie 2.1 Brushless
  CF_PLATFORM_COUNT  = 2,
} cf_platform_t;

// Thrust of one rotor against effective motor voltage V: c0 + c1 V + c2 V^2 + c3 V^3 [N].
typedef struct {
  float c0;  // [N]
  float c1;  // [N/V]
  float c2;  // [N/V^2]
  float c3;  // [N/V^3]

  float thrust_min;        // [N] per motor, the smallest thrust that is commanded at all
  float thrust_max;        // [N] per motor, at full command
  float thrust_to_torque;  // [m], reaction torque per thrust
} cf_thrust_curve_t;

typedef struct {
  const char *name;  // "cf2" or "cf21bl"
  const char *title;

  float mass;        // [kg], as the onboard software believes it
  float arm_length;  // [m], motor axis to center

  float battery_low;  // [V], from here on a client is warned

  bool requires_arming;  // a client must arm it; otherwise it arms itself

  cf_thrust_curve_t thrust;
} cf_platform_facts_t;

// Returns the facts about a platform, or null for an unknown number.
const cf_platform_facts_t *cf_platform_facts(cf_platform_t platform);

#endif  // CF_PLATFORM_H
