/* What the builtin provider adds to the controller of Brescianini: power-on and parameters. */
#ifndef CF_BUILTIN_CONTROL_CONTROLLER_BRESCIANINI_H
#define CF_BUILTIN_CONTROL_CONTROLLER_BRESCIANINI_H

#include "api/controller_brescianini.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

// Writes the whole struct: default gains, the mass of the platform, all memory zero. Returns
// CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_controller_brescianini_boot(controllerBrescianini_t *self, cf_platform_t platform);

// Group ctrlAtt, offsets relative to controllerBrescianini_t. There are no log variables.
cf_variables_t cf_controller_brescianini_parameters(void);

#endif  // CF_BUILTIN_CONTROL_CONTROLLER_BRESCIANINI_H
