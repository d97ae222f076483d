#include "library/guard.h"

#include "library/captured_variables.h"
#include "library/image.h"
#include "library/inner.h"
#include "library/work.h"

static const cf_provider_t *inner CF_LIBRARY_KEEP = NULL;

// How every function of the table looks. `enter_` and `leave_` say what happens to the image,
// `call_` is the work, `otherwise_` is what comes back after a failure (empty for void).
#define GUARDED(type_, name_, parameters_, enter_, leave_, call_, otherwise_) \
  static type_ name_ parameters_ {                                            \
    enter_(state, #name_);                                                    \
    const int signal = sigsetjmp(cf_work_rescue, 0);                          \
    if (signal == 0) {                                                        \
      cf_work_protect();                                                      \
      const type_ result = call_;                                             \
      leave_(state);                                                          \
      return result;                                                          \
    }                                                                         \
    cf_work_abandon(signal);                                                  \
    return otherwise_;                                                        \
  }

#define GUARDED_VOID(name_, parameters_, leave_, call_) \
  static void name_ parameters_ {                       \
    cf_work_enter(state, #name_);                       \
    const int signal = sigsetjmp(cf_work_rescue, 0);    \
    if (signal == 0) {                                  \
      cf_work_protect();                                \
      call_;                                            \
      leave_(state);                                    \
    } else {                                            \
      cf_work_abandon(signal);                          \
    }                                                   \
  }

// Functions of the inner table that change the state, and those that do not.
#define DO(name_, parameters_, ...) \
  GUARDED_VOID(name_, parameters_, cf_work_leave, inner->name_(__VA_ARGS__))
#define ANSWER(type_, name_, otherwise_, parameters_, ...)                                    \
  GUARDED(type_, name_, parameters_, cf_work_enter, cf_work_leave, inner->name_(__VA_ARGS__), \
          otherwise_)
#define LOOK(type_, name_, otherwise_, parameters_, ...)                     \
  GUARDED(type_, name_, parameters_, cf_work_enter, cf_work_leave_unchanged, \
          inner->name_(__VA_ARGS__), otherwise_)

// The same for functions that take the time as an argument.
#define AT_NOW(call_) (cf_work_tell_time(now_ms), call_)
#define DO_NOW(name_, parameters_, ...) \
  GUARDED_VOID(name_, parameters_, cf_work_leave, AT_NOW(inner->name_(__VA_ARGS__)))

// ------------------------------------------------------------------------------------------- boot

GUARDED(cf_status_t, init, (void *state, cf_platform_t platform, uint32_t now_ms),
        cf_work_enter_factory, cf_work_leave, AT_NOW(inner->init(state, platform, now_ms)),
        CF_ERR_STATE)

// ------------------------------------------------------------------------- controllers and mixer

ANSWER(cf_status_t, controller_init, CF_ERR_STATE, (void *state, int type), state, type)
LOOK(int, controller_type, ControllerTypeAutoSelect, (const void *state), state)
DO(controller,
   (void *state, control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
    const state_t *estimate, stabilizerStep_t step),
   state, control, setpoint, sensors, estimate, step)
DO(reset_position_control, (void *state, const point_t *position), state, position)

DO(power_distribution, (void *state, const control_t *control, motors_thrust_uncapped_t *uncapped),
   state, control, uncapped)
DO(battery_compensate,
   (void *state, const motors_thrust_uncapped_t *uncapped, float supply_voltage,
    motors_thrust_uncapped_t *compensated),
   state, uncapped, supply_voltage, compensated)
ANSWER(bool, power_cap, false,
       (void *state, const motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *pwm), state,
       uncapped, pwm)
LOOK(uint32_t, idle_thrust, 0, (const void *state), state)
DO(motor_override, (void *state, float battery_voltage, motors_thrust_pwm_t *pwm), state,
   battery_voltage, pwm)

// ------------------------------------------------------------------------------------- estimators

DO_NOW(kalman_init, (void *state, uint32_t now_ms), state, now_ms)
DO_NOW(kalman_predict,
       (void *state, const Axis3f *acc, const Axis3f *gyro, uint32_t now_ms, bool is_flying), state,
       acc, gyro, now_ms, is_flying)
DO_NOW(kalman_add_process_noise, (void *state, uint32_t now_ms), state, now_ms)
DO_NOW(kalman_update,
       (void *state, const measurement_t *measurement, const Axis3f *gyro_latest, uint32_t now_ms),
       state, measurement, gyro_latest, now_ms)
ANSWER(bool, kalman_finalize, false, (void *state), state)
LOOK(bool, kalman_is_within_bounds, true, (const void *state), state)
GUARDED_VOID(kalman_externalize, (const void *state, state_t *estimate, const Axis3f *acc),
             cf_work_leave_unchanged, inner->kalman_externalize(state, estimate, acc))
DO(kalman_disable_attitude_reversion, (void *state), state)

DO(complementary_init, (void *state), state)
DO_NOW(complementary,
       (void *state, const cf_latest_samples_t *latest, state_t *estimate, stabilizerStep_t step,
        uint32_t now_ms),
       state, latest, estimate, step, now_ms)

DO(out_of_tree_estimator_init, (void *state), state)
DO_NOW(out_of_tree_estimator,
       (void *state, const measurement_t *queue, int count, state_t *estimate,
        stabilizerStep_t step, uint32_t now_ms),
       state, queue, count, estimate, step, now_ms)

// ---------------------------------------------------------------------------------------- planner

#define REFUSED 1
#define IDLE 0  // plan_state

ANSWER(int, plan_takeoff, REFUSED,
       (void *state, const cf_plan_start_t *from, float height, float yaw, float duration, float t),
       state, from, height, yaw, duration, t)
ANSWER(int, plan_land, REFUSED,
       (void *state, const cf_plan_start_t *from, float height, float yaw, float duration, float t),
       state, from, height, yaw, duration, t)
ANSWER(int, plan_go_to, REFUSED,
       (void *state, const uint8_t *memory, const cf_plan_start_t *from, bool relative, bool linear,
        struct vec goal, float yaw, float duration, float t),
       state, memory, from, relative, linear, goal, yaw, duration, t)
ANSWER(int, plan_spiral, REFUSED,
       (void *state, const cf_plan_start_t *from, const cf_spiral_t *spiral, float t), state, from,
       spiral, t)
ANSWER(int, plan_start_trajectory, REFUSED,
       (void *state, const uint8_t *memory, const cf_uploaded_trajectory_t *trajectory,
        const cf_plan_start_t *from, float t),
       state, memory, trajectory, from, t)
DO(plan_stop, (void *state), state)
DO(plan_disable, (void *state), state)
LOOK(bool, plan_is_stopped, true, (const void *state), state)
LOOK(bool, plan_is_disabled, false, (const void *state), state)
LOOK(bool, plan_is_finished, true, (const void *state, const uint8_t *memory, float t), state,
     memory, t)
LOOK(int, plan_state, IDLE, (const void *state), state)
ANSWER(struct traj_eval, plan_current_goal, (struct traj_eval){.yaw = 0.0f},
       (void *state, const uint8_t *memory, float t), state, memory, t)

LOOK(bool, collision_avoidance_is_enabled, false, (const void *state), state)
DO_NOW(collision_avoidance,
       (void *state, setpoint_t *setpoint, const cf_peer_t *peers, const sensorData_t *sensors,
        const state_t *estimate, uint32_t now_ms),
       state, setpoint, peers, sensors, estimate, now_ms)

// ----------------------------------------------------------------------------------------- system

GUARDED(cf_status_t, system_boot, (void *state, const cf_system_boot_t *boot), cf_work_enter,
        cf_work_leave, inner->system->boot(state, boot), CF_ERR_STATE)

static void system_tick_now(void *state, const cf_system_inputs_t *inputs,
                            cf_system_outputs_t *outputs) {
  cf_work_tell_time(inputs->now_ms);
  inner->system->tick(state, inputs, outputs);
}

GUARDED_VOID(system_tick,
             (void *state, const cf_system_inputs_t *inputs, cf_system_outputs_t *outputs),
             cf_work_leave, system_tick_now(state, inputs, outputs))
GUARDED(bool, system_set_setpoint,
        (void *state, const setpoint_t *setpoint, int priority, uint32_t now_ms), cf_work_enter,
        cf_work_leave, AT_NOW(inner->system->set_setpoint(state, setpoint, priority, now_ms)),
        false)
GUARDED(int, system_packet,
        (void *state, uint8_t port, uint8_t channel, const uint8_t *data, int length,
         uint8_t reply[CF_SYSTEM_PACKET_BYTES], uint32_t now_ms),
        cf_work_enter, cf_work_leave,
        AT_NOW(inner->system->packet(state, port, channel, data, length, reply, now_ms)), 0)
GUARDED(bool, system_request, (void *state, cf_system_request_t what, uint32_t now_ms),
        cf_work_enter, cf_work_leave, AT_NOW(inner->system->request(state, what, now_ms)), false)
GUARDED(bool, system_read, (void *state, uint32_t offset, uint32_t length, uint8_t *data),
        cf_work_enter, cf_work_leave_unchanged,
        inner->system->read_trajectory(state, offset, length, data), false)
GUARDED(bool, system_write, (void *state, uint32_t offset, uint32_t length, const uint8_t *data),
        cf_work_enter, cf_work_leave, inner->system->write_trajectory(state, offset, length, data),
        false)

static cf_system_t guarded_system CF_LIBRARY_KEEP = {
    .boot             = system_boot,
    .tick             = system_tick,
    .set_setpoint     = system_set_setpoint,
    .packet           = system_packet,
    .request          = system_request,
    .read_trajectory  = system_read,
    .write_trajectory = system_write,
};

// -------------------------------------------------------------------------------------- variables

static void run_callbacks(void *state, const char *group, const char *name) {
  cf_captured_parameter_written(group, name);
  if (inner->parameter_written != NULL) {
    inner->parameter_written(state, group, name);
  }
}

static void compute_logs(void *state) {
  cf_captured_refresh_logs();
  if (inner->refresh_logs != NULL) {
    inner->refresh_logs(state);
  }
}

GUARDED_VOID(parameter_written, (void *state, const char *group, const char *name), cf_work_leave,
             run_callbacks(state, group, name))
GUARDED_VOID(refresh_logs, (void *state), cf_work_leave, compute_logs(state))

static int with_captured(int (*list)(cf_variables_t *, int), cf_variables_t captured,
                         cf_variables_t *tables, int capacity) {
  const int count = list != NULL ? list(tables, capacity) : 0;
  if (captured.count == 0) {
    return count;
  }
  if (count < capacity) {
    tables[count] = captured;
  }
  return count + 1;
}

static int parameters(cf_variables_t *tables, int capacity) {
  return with_captured(inner->parameters, cf_captured_parameters(), tables, capacity);
}

static int logs(cf_variables_t *tables, int capacity) {
  return with_captured(inner->logs, cf_captured_logs(), tables, capacity);
}

// ------------------------------------------------------------------------------------------ table

static cf_provider_t guarded CF_LIBRARY_KEEP = {
    .begin                             = cf_work_begin,
    .end                               = cf_work_end,
    .init                              = init,
    .controller_init                   = controller_init,
    .controller_type                   = controller_type,
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
    .out_of_tree_estimator_init        = out_of_tree_estimator_init,
    .out_of_tree_estimator             = out_of_tree_estimator,
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
    .parameter_written                 = parameter_written,
    .refresh_logs                      = refresh_logs,
};

const cf_provider_t *cf_guard_open(const cf_library_host_t *host) {
  inner = cf_library_inner();
  cf_work_open(host);
  guarded.name            = inner->name;
  guarded.platform        = inner->platform;
  guarded.state_bytes     = cf_image_bytes();
  guarded.controller_name = inner->controller_name;
  if (inner->out_of_tree_estimator == NULL) {
    guarded.out_of_tree_estimator_init = NULL;
    guarded.out_of_tree_estimator      = NULL;
  }
  if (inner->system != NULL) {
    guarded_system.modules = inner->system->modules;
    guarded.system         = &guarded_system;
  }
  return &guarded;
}
