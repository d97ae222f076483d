/* The inner table of a library that was made of a checkout. */

#include "bitcraze/adapter.h"

#include "bitcraze/own/complementary.h"
#include "bitcraze/variables.h"
#include "library/out_of_tree.h"

// Gains and motors of the platform were chosen when the checkout was compiled.
#if CONFIG_PLATFORM_CF2
#define PLATFORM CF_PLATFORM_CF2
#elif CONFIG_PLATFORM_CF21BL
#define PLATFORM CF_PLATFORM_CF21BL
#else
#define PLATFORM (-1)  // an airframe that is not simulated may fly any that is
#endif

static cf_status_t init(void *state CF_UNUSED, cf_platform_t platform, uint32_t now_ms) {
  if (cf_platform_facts(platform) == NULL || (PLATFORM != -1 && (int)platform != PLATFORM)) {
    return CF_ERR_UNKNOWN;
  }
#if CF_SYSTEM
  // their modules boot by themselves, see cf_system_t.boot
  (void)now_ms;
  cf_motors_boot(platform);
#else
  // the order of the vehicle: estimator, controller, power distribution, planner
  cf_kalman_boot(now_ms);
  cf_own_complementary_boot();
  cf_controllers_boot();
  cf_power_boot(platform);
  cf_planning_boot();
#endif
  return CF_OK;
}

#if CF_SYSTEM
#include "bitcraze/system/system.h"
#endif

static const cf_provider_t WITHOUT_ESTIMATOR = {
    .name                              = "bitcraze",
    .platform                          = PLATFORM,
    .init                              = init,
    .controller_init                   = cf_controllers_init,
    .controller_type                   = cf_controllers_type,
    .controller_name                   = cf_controllers_name,
    .controller                        = cf_controllers_run,
    .reset_position_control            = cf_controllers_reset_position,
    .power_distribution                = cf_power_mix,
    .battery_compensate                = cf_power_compensate,
    .power_cap                         = cf_power_cap,
    .idle_thrust                       = cf_power_idle_thrust,
    .motor_override                    = cf_power_override,
    .kalman_init                       = cf_kalman_init,
    .kalman_predict                    = cf_kalman_predict,
    .kalman_add_process_noise          = cf_kalman_add_process_noise,
    .kalman_update                     = cf_measurements_fuse,
    .kalman_finalize                   = cf_kalman_finalize,
    .kalman_is_within_bounds           = cf_kalman_is_within_bounds,
    .kalman_externalize                = cf_kalman_externalize,
    .kalman_disable_attitude_reversion = cf_kalman_disable_attitude_reversion,
    .complementary_init                = cf_complementary_select,
    .complementary                     = cf_complementary_run,
    .plan_takeoff                      = cf_planning_takeoff,
    .plan_land                         = cf_planning_land,
    .plan_go_to                        = cf_planning_go_to,
    .plan_spiral                       = cf_planning_spiral,
    .plan_start_trajectory             = cf_planning_start_trajectory,
    .plan_stop                         = cf_planning_stop,
    .plan_disable                      = cf_planning_disable,
    .plan_is_stopped                   = cf_planning_is_stopped,
    .plan_is_disabled                  = cf_planning_is_disabled,
    .plan_is_finished                  = cf_planning_is_finished,
    .plan_state                        = cf_planning_state,
    .plan_current_goal                 = cf_planning_current_goal,
    .collision_avoidance_is_enabled    = cf_avoidance_is_enabled,
    .collision_avoidance               = cf_avoidance_run,
    .parameters                        = cf_own_parameters,
    .logs                              = cf_own_logs,
};

static cf_provider_t table CF_LIBRARY_KEEP = {.name = NULL};

const cf_provider_t *cf_library_inner(void) {
  table = WITHOUT_ESTIMATOR;
  if (cf_out_of_tree_has_estimator()) {
    table.out_of_tree_estimator_init = cf_out_of_tree_select_estimator;
    table.out_of_tree_estimator      = cf_out_of_tree_estimate;
  }
#if CF_SYSTEM
  table.system = cf_system();
#endif
  return &table;
}
