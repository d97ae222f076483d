#include "builtin/builtin.h"

#include <string.h>

_Static_assert(sizeof(cf_builtin_t) <= CF_PROVIDER_STATE_BYTES, "the block is of fixed size");

// ----------------------------------------------------------------------------------- controllers

// the names are those of the firmware's console
static const char *controller_name(int type) {
  switch (type) {
    case ControllerTypePID:
      return "PID";
    case ControllerTypeMellinger:
      return "Mellinger";
    case ControllerTypeINDI:
      return "INDI";
    case ControllerTypeBrescianini:
      return "Brescianini";
    case ControllerTypeLee:
      return "Lee";
    default:
      return NULL;
  }
}

// what each controller does when it is selected; the others keep what they have
static void reinit_controller(cf_builtin_t *self) {
  switch (self->controller_type) {
    case ControllerTypeMellinger:
      controllerMellingerReset(&self->mellinger);
      break;
    case ControllerTypeINDI:
      controllerINDIInit(&self->indi, &self->pid);
      break;
    case ControllerTypeBrescianini:
      controllerBrescianiniInit(&self->brescianini);
      break;
    case ControllerTypeLee:
      controllerLeeReset(&self->lee);
      break;
    default:
      cf_controller_pid_reinit(&self->pid);
      break;
  }
}

static cf_status_t controller_init(void *state, int type) {
  cf_builtin_t *self   = state;
  const int     wanted = type == ControllerTypeAutoSelect ? ControllerTypePID : type;
  if (controller_name(wanted) == NULL) {
    return CF_ERR_UNKNOWN;
  }
  self->controller_type = wanted;
  reinit_controller(self);
  return CF_OK;
}

static int controller_type(const void *state) {
  return ((const cf_builtin_t *)state)->controller_type;
}

static void controller(void *state, control_t *control, const setpoint_t *setpoint,
                       const sensorData_t *sensors, const state_t *estimate,
                       stabilizerStep_t step) {
  cf_builtin_t *self = state;
  switch (self->controller_type) {
    case ControllerTypeMellinger:
      controllerMellinger(&self->mellinger, control, setpoint, sensors, estimate, step);
      break;
    case ControllerTypeINDI:
      controllerINDI(&self->indi, &self->pid, control, setpoint, sensors, estimate, step);
      break;
    case ControllerTypeBrescianini:
      controllerBrescianini(&self->brescianini, control, setpoint, sensors, estimate, step);
      break;
    case ControllerTypeLee:
      controllerLee(&self->lee, control, setpoint, sensors, estimate, step);
      break;
    default:
      cf_controller_pid_update(&self->pid, control, setpoint, sensors, estimate, step);
      break;
  }
}

static void reset_position_control(void *state, const point_t *position) {
  cf_position_controller_t *loops = &((cf_builtin_t *)state)->pid.position;
  cf_position_controller_reset(loops, position->x, position->y, position->z);
  cf_position_controller_reset_filters(loops);
}

static void power_distribution(void *state, const control_t *control,
                               motors_thrust_uncapped_t *uncapped) {
  cf_power_distribution_update(&((cf_builtin_t *)state)->power, control, uncapped);
}

static void battery_compensate(void *state, const motors_thrust_uncapped_t *uncapped,
                               float supply_voltage, motors_thrust_uncapped_t *compensated) {
  cf_power_distribution_compensate(&((cf_builtin_t *)state)->power, uncapped, supply_voltage,
                                   compensated);
}

static bool power_cap(void *state, const motors_thrust_uncapped_t *uncapped,
                      motors_thrust_pwm_t *pwm) {
  return cf_power_distribution_cap(&((cf_builtin_t *)state)->power, uncapped, pwm);
}

static uint32_t idle_thrust(const void *state) {
  return cf_power_distribution_idle_thrust(&((const cf_builtin_t *)state)->power);
}

static void motor_override(void *state, float battery_voltage, motors_thrust_pwm_t *pwm) {
  cf_builtin_t *self = state;
  cf_motor_override_apply(&self->motor_override, &self->power.thrust, battery_voltage, pwm);
}

// --------------------------------------------------------------------------------- Kalman filter

static void kalman_init(void *state, uint32_t now_ms) {
  cf_kalman_init(&((cf_builtin_t *)state)->kalman, now_ms);
}

static void kalman_predict(void *state, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms,
                           bool is_flying) {
  cf_kalman_predict(&((cf_builtin_t *)state)->kalman, acc, gyro, now_ms, is_flying);
}

static void kalman_add_process_noise(void *state, uint32_t now_ms) {
  cf_kalman_add_process_noise(&((cf_builtin_t *)state)->kalman, now_ms);
}

static void kalman_update(void *state, const measurement_t *measurement, const Axis3f *gyro_latest,
                          uint32_t now_ms) {
  cf_kalman_update(&((cf_builtin_t *)state)->kalman, measurement, gyro_latest, now_ms);
}

static bool kalman_finalize(void *state) {
  return cf_kalman_finalize(&((cf_builtin_t *)state)->kalman);
}

static bool kalman_is_within_bounds(const void *state) {
  return cf_kalman_is_within_bounds(&((const cf_builtin_t *)state)->kalman);
}

static void kalman_externalize(const void *state, state_t *estimate, const Axis3f *acc) {
  cf_kalman_externalize(&((const cf_builtin_t *)state)->kalman, estimate, acc);
}

static void kalman_disable_attitude_reversion(void *state) {
  ((cf_builtin_t *)state)->kalman.params.attitudeReversion = 0.0f;
}

// ----------------------------------------------------------------------- complementary estimator

static void complementary_init(void *state) {
  cf_complementary_init(&((cf_builtin_t *)state)->complementary);
}

static void complementary(void *state, const cf_latest_samples_t *latest, state_t *estimate,
                          stabilizerStep_t step, uint32_t now_ms) {
  cf_complementary_update(&((cf_builtin_t *)state)->complementary, latest, estimate, step, now_ms);
}

// --------------------------------------------------------------------------------------- planner

static int plan_takeoff(void *state, const cf_plan_start_t *from, float height, float yaw,
                        float duration, float t) {
  return cf_planner_takeoff(&((cf_builtin_t *)state)->planner, from, height, yaw, duration, t);
}

static int plan_land(void *state, const cf_plan_start_t *from, float height, float yaw,
                     float duration, float t) {
  return cf_planner_land(&((cf_builtin_t *)state)->planner, from, height, yaw, duration, t);
}

static int plan_go_to(void *state, const uint8_t *memory, const cf_plan_start_t *from,
                      bool relative, bool linear, struct vec goal, float yaw, float duration,
                      float t) {
  return cf_planner_go_to(&((cf_builtin_t *)state)->planner, memory, from, relative, linear, goal,
                          yaw, duration, t);
}

static int plan_spiral(void *state, const cf_plan_start_t *from, const cf_spiral_t *spiral,
                       float t) {
  return cf_planner_spiral(&((cf_builtin_t *)state)->planner, from, spiral, t);
}

static int plan_start_trajectory(void *state, const uint8_t *memory,
                                 const cf_uploaded_trajectory_t *trajectory,
                                 const cf_plan_start_t *from, float t) {
  return cf_planner_start_trajectory(&((cf_builtin_t *)state)->planner, memory, trajectory, from,
                                     t);
}

static void plan_stop(void *state) {
  cf_planner_stop(&((cf_builtin_t *)state)->planner);
}

static void plan_disable(void *state) {
  cf_planner_disable(&((cf_builtin_t *)state)->planner);
}

static bool plan_is_stopped(const void *state) {
  return cf_planner_is_stopped(&((const cf_builtin_t *)state)->planner);
}

static bool plan_is_disabled(const void *state) {
  return cf_planner_is_disabled(&((const cf_builtin_t *)state)->planner);
}

static bool plan_is_finished(const void *state, const uint8_t *memory, float t) {
  return cf_planner_is_finished(&((const cf_builtin_t *)state)->planner, memory, t);
}

static int plan_state(const void *state) {
  return cf_planner_state(&((const cf_builtin_t *)state)->planner);
}

static struct traj_eval plan_current_goal(void *state, const uint8_t *memory, float t) {
  return cf_planner_current_goal(&((cf_builtin_t *)state)->planner, memory, t);
}

// --------------------------------------------------------------------------- collision avoidance

static bool collision_avoidance_is_enabled(const void *state) {
  return ((const cf_builtin_t *)state)->collision_avoidance.enable != 0;
}

static void collision_avoidance(void *state, setpoint_t *setpoint, const cf_peer_t *peers,
                                const sensorData_t *sensors, const state_t *estimate,
                                uint32_t now_ms) {
  cf_collision_avoidance_update(&((cf_builtin_t *)state)->collision_avoidance, setpoint, peers,
                                PEER_LOCALIZATION_MAX_NEIGHBORS, sensors, estimate, now_ms);
}

// --------------------------------------------------------------------------- boot and variables

static cf_status_t init(void *state, cf_platform_t platform, uint32_t now_ms) {
  cf_builtin_t *self = state;
  memset(self, 0, sizeof *self);
  self->platform        = platform;
  self->controller_type = ControllerTypePID;
  cf_status_t status    = cf_controller_pid_init(&self->pid, platform);
  if (status == CF_OK) {
    status = cf_power_distribution_init(&self->power, platform);
  }
  if (status == CF_OK) {
    status = cf_controller_mellinger_init(&self->mellinger, platform);
  }
  if (status == CF_OK) {
    status = cf_controller_lee_init(&self->lee, platform);
  }
  if (status == CF_OK) {
    cf_motor_override_init(&self->motor_override);
    cf_planner_init(&self->planner);
    cf_collision_avoidance_init(&self->collision_avoidance);
    cf_kalman_boot(&self->kalman, now_ms);
    cf_controller_indi_boot(&self->indi);
    status = cf_controller_brescianini_boot(&self->brescianini, platform);
    cf_complementary_boot(&self->complementary, CF_SENSFUSION6_MAHONY);
  }
  return status;
}

static int list(cf_variables_t *tables, int capacity, const cf_variables_t *own, int count) {
  for (int i = 0; i < count && i < capacity; i++) {
    tables[i] = own[i];
  }
  return count;
}

static cf_variables_t at(cf_variables_t table, size_t base) {
  table.base += (uint32_t)base;
  return table;
}

#define PART(member_) offsetof(cf_builtin_t, member_)

static int parameters(cf_variables_t *tables, int capacity) {
  const cf_variables_t own[] = {
      at(cf_attitude_controller_parameters(), PART(pid.attitude)),
      at(cf_position_controller_parameters(), PART(pid.position)),
      at(cf_controller_mellinger_parameters(), PART(mellinger)),
      at(cf_controller_lee_parameters(), PART(lee)),
      at(cf_power_distribution_parameters(), PART(power)),
      at(cf_motor_override_parameters(), PART(motor_override)),
      at(cf_kalman_parameters(), PART(kalman)),
      at(cf_controller_indi_parameters(), PART(indi)),
      at(cf_position_controller_indi_parameters(), PART(indi.position)),
      at(cf_controller_brescianini_parameters(), PART(brescianini)),
      at(cf_sensfusion6_parameters(), PART(complementary.attitude)),
      at(cf_altitude_parameters(), PART(complementary.altitude)),
      at(cf_collision_avoidance_parameters(), PART(collision_avoidance)),
  };
  return list(tables, capacity, own, (int)(sizeof own / sizeof own[0]));
}

static int logs(cf_variables_t *tables, int capacity) {
  const cf_variables_t own[] = {
      at(cf_controller_pid_logs(), PART(pid)),
      at(cf_attitude_controller_logs(), PART(pid.attitude)),
      at(cf_position_controller_logs(), PART(pid.position)),
      at(cf_controller_mellinger_logs(), PART(mellinger)),
      at(cf_controller_lee_logs(), PART(lee)),
      at(cf_kalman_logs(), PART(kalman)),
      at(cf_controller_indi_logs(), PART(indi)),
      at(cf_position_controller_indi_logs(), PART(indi.position)),
      at(cf_sensfusion6_logs(), PART(complementary.attitude)),
      at(cf_altitude_logs(), PART(complementary.altitude)),
      at(cf_collision_avoidance_logs(), PART(collision_avoidance)),
  };
  return list(tables, capacity, own, (int)(sizeof own / sizeof own[0]));
}

static const cf_provider_t BUILTIN = {
    .name                              = "builtin",
    .platform                          = -1,
    .state_bytes                       = (sizeof(cf_builtin_t) + 7) / 8 * 8,
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

    .collision_avoidance_is_enabled = collision_avoidance_is_enabled,
    .collision_avoidance            = collision_avoidance,

    .parameters = parameters,
    .logs       = logs,
};

const cf_provider_t *cf_builtin_provider(void) {
  return &BUILTIN;
}
