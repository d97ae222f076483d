/* The Lee controller of api/controller_lee.h as a part of the provider. */
#ifndef CF_BUILTIN_CONTROL_CONTROLLER_LEE_H
#define CF_BUILTIN_CONTROL_CONTROLLER_LEE_H

#include "api/controller_lee.h"
#include "platform.h"
#include "status.h"
#include "variables.h"

// Writes the whole struct: the state after boot, with mass and thrust of the platform. Returns
// CF_ERR_UNKNOWN, and writes nothing, for an unknown platform.
cf_status_t cf_controller_lee_init(controllerLee_t *lee, cf_platform_t platform);

// Tables of ctrlLee, offsets relative to controllerLee_t.
cf_variables_t cf_controller_lee_parameters(void);
cf_variables_t cf_controller_lee_logs(void);

#endif  // CF_BUILTIN_CONTROL_CONTROLLER_LEE_H
