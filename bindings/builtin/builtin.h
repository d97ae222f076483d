/* Provider "builtin": the firmware's algorithms, written from the dossiers, with all state in one
 * block. */
#ifndef CF_BUILTIN_BUILTIN_H
#define CF_BUILTIN_BUILTIN_H

#include "builtin/controller_pid.h"
#include "builtin/kalman/kalman.h"
#include "builtin/motor_override.h"
#include "builtin/planner.h"
#include "builtin/power_distribution.h"
#include "provider.h"

typedef struct {
  cf_platform_t platform;
  int           controller_type;  // the active one

  cf_kalman_t             kalman;
  cf_controller_pid_t     pid;
  cf_power_distribution_t power;
  cf_motor_override_t     motor_override;
  cf_planner_t            planner;
} cf_builtin_t;

const cf_provider_t *cf_builtin_provider(void);

#endif  // CF_BUILTIN_BUILTIN_H
