/* Provider "builtin": the firmware's algorithms, written from docs/reference, with all state in one
 * block. */
#ifndef CF_BUILTIN_BUILTIN_H
#define CF_BUILTIN_BUILTIN_H

#include "builtin/complementary/complementary.h"
#include "builtin/control/controller_brescianini.h"
#include "builtin/control/controller_indi.h"
#include "builtin/control/controller_lee.h"
#include "builtin/control/controller_mellinger.h"
#include "builtin/control/controller_pid.h"
#include "builtin/kalman/kalman.h"
#include "builtin/planning/collision_avoidance.h"
#include "builtin/planning/planner.h"
#include "builtin/power/motor_override.h"
#include "builtin/power/power_distribution.h"
#include "provider.h"

typedef struct {
  cf_platform_t platform;
  int           controller_type;  // the active one

  // what flies by default, and then what flies when it is selected
  cf_kalman_t              kalman;
  cf_controller_pid_t      pid;
  cf_power_distribution_t  power;
  cf_motor_override_t      motor_override;
  cf_planner_t             planner;
  cf_complementary_t       complementary;
  controllerMellinger_t    mellinger;
  controllerINDI_t         indi;
  controllerBrescianini_t  brescianini;
  controllerLee_t          lee;
  cf_collision_avoidance_t collision_avoidance;
} cf_builtin_t;

const cf_provider_t *cf_builtin_provider(void);

#endif  // CF_BUILTIN_BUILTIN_H
