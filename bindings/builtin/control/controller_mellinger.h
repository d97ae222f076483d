/* The Mellinger controller of api/controller_mellinger.h as a part of the provider. */
#ifndef CF_BUILTIN_CONTROL_CONTROLLER_MELLINGER_H
#define CF_BUILTIN_CONTROL_CONTROLLER_MELLINGER_H

#include "api/controller_mellinger.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

// Writes the whole struct: the state after boot, with the mass of the platform. Returns
// CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_controller_mellinger_init(controllerMellinger_t *mellinger, cf_platform_t platform);

// What the firmware does when this controller is selected: all six integrals start over. Gains and
// the rates of the call before stay.
void controllerMellingerReset(controllerMellinger_t *self);

// Tables of ctrlMel, offsets relative to controllerMellinger_t.
cf_variables_t cf_controller_mellinger_parameters(void);
cf_variables_t cf_controller_mellinger_logs(void);

#endif  // CF_BUILTIN_CONTROL_CONTROLLER_MELLINGER_H
