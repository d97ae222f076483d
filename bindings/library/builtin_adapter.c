/* Inner table of a library that was made of our own implementation and a user's own C.
 *
 * The builtin provider has its state in one block, so a file-scope variable of that type is all it
 * takes. The user's code may work on it too, by the firmware's names (app/names_over_builtin.c). */
#include "library/builtin_adapter.h"

#include "library/image.h"
#include "library/inner.h"
#include "library/out_of_tree.h"
#include "library/work.h"

cf_builtin_t cf_library_builtin;

static bool is_out_of_tree;  // a part of the image: what flies this drone

// Null where the library was linked without.
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) __attribute__((weak));
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep)
    __attribute__((weak));
bool estimatorDequeue(measurement_t *measurement);

#define BUILTIN (cf_builtin_provider())
#define DRONE (&cf_library_builtin)

// The inner table is called with the image in place, so that `state` says nothing new.
#define UNUSED __attribute__((unused))

// ----------------------------------------------------------------------------- controllers, boot

static cf_status_t init(void *state UNUSED, cf_platform_t platform, uint32_t now_ms) {
  return BUILTIN->init(DRONE, platform, now_ms);
}

static cf_status_t controller_init(void *state UNUSED, int type) {
  if (type == ControllerTypeOot && cf_out_of_tree_has_controller()) {
    is_out_of_tree = true;
    cf_out_of_tree_init_controller();
    return CF_OK;
  }
  const cf_status_t status = BUILTIN->controller_init(DRONE, type);
  if (status == CF_OK) {
    is_out_of_tree = false;
  }
  return status;
}

static int controller_type(const void *state UNUSED) {
  return is_out_of_tree ? ControllerTypeOot : BUILTIN->controller_type(DRONE);
}

static const char *controller_name(int type) {
  if (type == ControllerTypeOot && cf_out_of_tree_has_controller()) {
    return CF_OUT_OF_TREE_NAME;
  }
  return BUILTIN->controller_name(type);
}

static void controller(void *state UNUSED, control_t *control, const setpoint_t *setpoint,
                       const sensorData_t *sensors, const state_t *estimate,
                       stabilizerStep_t step) {
  if (is_out_of_tree) {
    cf_work_on("controllerOutOfTree");
    controllerOutOfTree(control, setpoint, sensors, estimate, step);
  } else {
    BUILTIN->controller(DRONE, control, setpoint, sensors, estimate, step);
  }
}

static void reset_position_control(void *state UNUSED, const point_t *position) {
  BUILTIN->reset_position_control(DRONE, position);
}

// ------------------------------------------------------------------------------------------ mixer

static void power_distribution(void *state UNUSED, const control_t *control,
                               motors_thrust_uncapped_t *uncapped) {
  BUILTIN->power_distribution(DRONE, control, uncapped);
}

static void battery_compensate(void *state UNUSED, const motors_thrust_uncapped_t *uncapped,
                               float supply_voltage, motors_thrust_uncapped_t *compensated) {
  BUILTIN->battery_compensate(DRONE, uncapped, supply_voltage, compensated);
}

static bool power_cap(void *state UNUSED, const motors_thrust_uncapped_t *uncapped,
                      motors_thrust_pwm_t *pwm) {
  return BUILTIN->power_cap(DRONE, uncapped, pwm);
}

static uint32_t idle_thrust(const void *state UNUSED) {
  return BUILTIN->idle_thrust(DRONE);
}

static void motor_override(void *state UNUSED, float battery_voltage, motors_thrust_pwm_t *pwm) {
  BUILTIN->motor_override(DRONE, battery_voltage, pwm);
}

// ------------------------------------------------------------------------------------- estimators

static void kalman_init(void *state UNUSED, uint32_t now_ms) {
  BUILTIN->kalman_init(DRONE, now_ms);
}

static void kalman_predict(void *state UNUSED, const Axis3f *acc, const Axis3f *gyro,
                           uint32_t now_ms, bool is_flying) {
  BUILTIN->kalman_predict(DRONE, acc, gyro, now_ms, is_flying);
}

static void kalman_add_process_noise(void *state UNUSED, uint32_t now_ms) {
  BUILTIN->kalman_add_process_noise(DRONE, now_ms);
}

static void kalman_update(void *state UNUSED, const measurement_t *measurement,
                          const Axis3f *gyro_latest, uint32_t now_ms) {
  BUILTIN->kalman_update(DRONE, measurement, gyro_latest, now_ms);
}

static bool kalman_finalize(void *state UNUSED) {
  return BUILTIN->kalman_finalize(DRONE);
}

static bool kalman_is_within_bounds(const void *state UNUSED) {
  return BUILTIN->kalman_is_within_bounds(DRONE);
}

static void kalman_externalize(const void *state UNUSED, state_t *estimate, const Axis3f *acc) {
  BUILTIN->kalman_externalize(DRONE, estimate, acc);
}

static void kalman_disable_attitude_reversion(void *state UNUSED) {
  BUILTIN->kalman_disable_attitude_reversion(DRONE);
}

static void complementary_init(void *state UNUSED) {
  BUILTIN->complementary_init(DRONE);
}

static void complementary(void *state UNUSED, const cf_latest_samples_t *latest, state_t *estimate,
                          stabilizerStep_t step, uint32_t now_ms) {
  BUILTIN->complementary(DRONE, latest, estimate, step, now_ms);
}

static void out_of_tree_estimator_init(void *state UNUSED) {
  cf_out_of_tree_init_estimator();
}

static void out_of_tree_estimator(void *state UNUSED, const measurement_t *queue, int count,
                                  state_t *estimate, stabilizerStep_t step,
                                  uint32_t now_ms UNUSED) {
  cf_out_of_tree_open_queue(queue, count, sizeof *queue);
  cf_work_on("estimatorOutOfTree");
  estimatorOutOfTree(estimate, step);
  cf_out_of_tree_close_queue();
}

bool estimatorDequeue(measurement_t *measurement) {
  const measurement_t *next = cf_out_of_tree_next();
  if (next != NULL) {
    *measurement = *next;
  }
  return next != NULL;
}

// ---------------------------------------------------------------------------------------- planner

static int plan_takeoff(void *state UNUSED, const cf_plan_start_t *from, float height, float yaw,
                        float duration, float t) {
  return BUILTIN->plan_takeoff(DRONE, from, height, yaw, duration, t);
}

static int plan_land(void *state UNUSED, const cf_plan_start_t *from, float height, float yaw,
                     float duration, float t) {
  return BUILTIN->plan_land(DRONE, from, height, yaw, duration, t);
}

static int plan_go_to(void *state UNUSED, const uint8_t *memory, const cf_plan_start_t *from,
                      bool relative, bool linear, struct vec goal, float yaw, float duration,
                      float t) {
  return BUILTIN->plan_go_to(DRONE, memory, from, relative, linear, goal, yaw, duration, t);
}

static int plan_spiral(void *state UNUSED, const cf_plan_start_t *from, const cf_spiral_t *spiral,
                       float t) {
  return BUILTIN->plan_spiral(DRONE, from, spiral, t);
}

static int plan_start_trajectory(void *state UNUSED, const uint8_t *memory,
                                 const cf_uploaded_trajectory_t *trajectory,
                                 const cf_plan_start_t *from, float t) {
  return BUILTIN->plan_start_trajectory(DRONE, memory, trajectory, from, t);
}

static void plan_stop(void *state UNUSED) {
  BUILTIN->plan_stop(DRONE);
}

static void plan_disable(void *state UNUSED) {
  BUILTIN->plan_disable(DRONE);
}

static bool plan_is_stopped(const void *state UNUSED) {
  return BUILTIN->plan_is_stopped(DRONE);
}

static bool plan_is_disabled(const void *state UNUSED) {
  return BUILTIN->plan_is_disabled(DRONE);
}

static bool plan_is_finished(const void *state UNUSED, const uint8_t *memory, float t) {
  return BUILTIN->plan_is_finished(DRONE, memory, t);
}

static int plan_state(const void *state UNUSED) {
  return BUILTIN->plan_state(DRONE);
}

static struct traj_eval plan_current_goal(void *state UNUSED, const uint8_t *memory, float t) {
  return BUILTIN->plan_current_goal(DRONE, memory, t);
}

// ---------------------------------------------------------------------------- collision avoidance

static bool collision_avoidance_is_enabled(const void *state UNUSED) {
  return BUILTIN->collision_avoidance_is_enabled(DRONE);
}

static void collision_avoidance(void *state UNUSED, setpoint_t *setpoint, const cf_peer_t *peers,
                                const sensorData_t *sensors, const state_t *estimate,
                                uint32_t now_ms) {
  BUILTIN->collision_avoidance(DRONE, setpoint, peers, sensors, estimate, now_ms);
}

// -------------------------------------------------------------------------------------- variables

// The tables of the builtin provider count from its own struct, those of a library from the block.
static int moved(int (*list)(cf_variables_t *, int), cf_variables_t *tables, int capacity) {
  const int      count = list(tables, capacity);
  const uint32_t at    = (uint32_t)cf_image_offset(DRONE, sizeof *DRONE);
  for (int i = 0; i < count && i < capacity; i++) {
    tables[i].base += at;
  }
  return count;
}

static int parameters(cf_variables_t *tables, int capacity) {
  return moved(BUILTIN->parameters, tables, capacity);
}

static int logs(cf_variables_t *tables, int capacity) {
  return moved(BUILTIN->logs, tables, capacity);
}

// ------------------------------------------------------------------------------------------ table

static const cf_provider_t WITHOUT_ESTIMATOR = {
    .name                              = "builtin",
    .platform                          = -1,
    .init                              = init,
    .controller_init                   = controller_init,
    .controller_type                   = controller_type,
    .controller_name                   = controller_name,
    .controller                        = controller,
    .reset_position_control            = reset_position_control,
    .power_distribution                = power_distribution,
    .battery_compensate                = battery_compensate,
    .power_cap                         = power_cap,
    .idle_thrust                       = idle_thrust,
    .motor_override                    = motor_override,
    .kalman_init                       = kalman_init,
    .kalman_predict                    = kalman_predict,
    .kalman_add_process_noise          = kalman_add_process_noise,
    .kalman_update                     = kalman_update,
    .kalman_finalize                   = kalman_finalize,
    .kalman_is_within_bounds           = kalman_is_within_bounds,
    .kalman_externalize                = kalman_externalize,
    .kalman_disable_attitude_reversion = kalman_disable_attitude_reversion,
    .complementary_init                = complementary_init,
    .complementary                     = complementary,
    .plan_takeoff                      = plan_takeoff,
    .plan_land                         = plan_land,
    .plan_go_to                        = plan_go_to,
    .plan_spiral                       = plan_spiral,
    .plan_start_trajectory             = plan_start_trajectory,
    .plan_stop                         = plan_stop,
    .plan_disable                      = plan_disable,
    .plan_is_stopped                   = plan_is_stopped,
    .plan_is_disabled                  = plan_is_disabled,
    .plan_is_finished                  = plan_is_finished,
    .plan_state                        = plan_state,
    .plan_current_goal                 = plan_current_goal,
    .collision_avoidance_is_enabled    = collision_avoidance_is_enabled,
    .collision_avoidance               = collision_avoidance,
    .parameters                        = parameters,
    .logs                              = logs,
};

static cf_provider_t table CF_LIBRARY_KEEP = {.name = NULL};

const cf_provider_t *cf_library_inner(void) {
  table = WITHOUT_ESTIMATOR;
  if (cf_out_of_tree_has_estimator()) {
    table.out_of_tree_estimator_init = out_of_tree_estimator_init;
    table.out_of_tree_estimator      = out_of_tree_estimator;
  }
  return &table;
}
