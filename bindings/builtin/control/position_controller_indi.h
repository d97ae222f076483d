/* What the builtin provider adds to the outer loop of the INDI controller: power-on and
 * variables. */
#ifndef CF_BUILTIN_CONTROL_POSITION_CONTROLLER_INDI_H
#define CF_BUILTIN_CONTROL_POSITION_CONTROLLER_INDI_H

#include "api/position_controller_indi.h"
#include "variables.h"

// Writes the whole struct: default gains, all memory zero. positionControllerINDIInit must follow.
void cf_position_controller_indi_boot(positionControllerINDI_t *self);

// Group posCtrlIndi, offsets relative to positionControllerINDI_t.
cf_variables_t cf_position_controller_indi_parameters(void);
cf_variables_t cf_position_controller_indi_logs(void);

#endif  // CF_BUILTIN_CONTROL_POSITION_CONTROLLER_INDI_H
