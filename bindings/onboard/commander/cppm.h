/* Emulation of a remote control: sticks as pulse lengths become a setpoint, scaled by the
 * parameters cppm.* (docs/reference/planner-commander.md#9.1). */
#ifndef CF_ONBOARD_COMMANDER_CPPM_H
#define CF_ONBOARD_COMMANDER_CPPM_H

#include <stdint.h>

#include "api/stabilizer_types.h"
#include "status.h"
#include "variables.h"

#define CF_CPPM_MAX_AUX 10

// What a stick does at its end.
typedef struct {
  float rateRoll;   // [deg/s]
  float ratePitch;  // [deg/s]
  float angPitch;   // [deg]
  float angRoll;    // [deg]
  float rateYaw;    // [deg/s]
} cf_cppm_t;

// Pulse lengths [us]: 1000 to 2000, 1500 in the middle.
typedef struct {
  uint16_t roll;
  uint16_t pitch;
  uint16_t yaw;
  uint16_t thrust;
  int      n_aux;
  uint16_t aux[CF_CPPM_MAX_AUX];  // the first one below 1500: roll and pitch are rates, not angles
} cf_cppm_sticks_t;

void cf_cppm_init(cf_cppm_t *cppm);

// Writes the whole setpoint. The thrust may exceed 65535 for pulses longer than 2000. Returns
// CF_ERR_VALUE, and writes nothing, when a scale makes a number that is not finite.
cf_status_t cf_setpoint_cppm(setpoint_t *setpoint, const cf_cppm_t *cppm,
                             const cf_cppm_sticks_t *sticks);

cf_variables_t cf_cppm_parameters(void);  // cppm.*

#endif  // CF_ONBOARD_COMMANDER_CPPM_H
