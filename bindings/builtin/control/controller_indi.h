/* What the builtin provider adds to the INDI controller: power-on and variables. */
#ifndef CF_BUILTIN_CONTROL_CONTROLLER_INDI_H
#define CF_BUILTIN_CONTROL_CONTROLLER_INDI_H

#include "api/controller_indi.h"
#include "builtin/control/position_controller_indi.h"
#include "variables.h"

// Writes the whole struct, outer loop included: default gains, all memory zero. controllerINDIInit
// must follow before the first step.
void cf_controller_indi_boot(controllerINDI_t *self);

// Group ctrlINDI, offsets relative to controllerINDI_t.
cf_variables_t cf_controller_indi_parameters(void);
cf_variables_t cf_controller_indi_logs(void);

#endif  // CF_BUILTIN_CONTROL_CONTROLLER_INDI_H
