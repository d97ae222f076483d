#include "onboard/onboard.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "onboard/firmware_modules.h"

#define SENSORS_START_UP 1000     // [ms], docs/reference/estimators.md#12.1
#define SUPPLY_START 4.2f         // [V], docs/reference/control-pid.md#14
#define SUPPLY_FILTER_GAIN 0.01f  // per control of the motors
#define LOOP_RATE_INTERVAL 500    // [ms]
#define EXT_POS_STD_DEV 0.01f     // [m]
#define EXT_QUAT_STD_DEV 4.5e-3f  // [rad]

static void tell_controller(cf_onboard_t *onboard, const cf_provider_t *provider) {
  _Static_assert(ControllerType_COUNT <= 10, "the number has one digit");
  char number[] = " (0) controller";
  number[2]     = (char)('0' + onboard->controller_type);
  cf_console_print_line(&onboard->console, "CONTROLLER: Using ",
                        provider->controller_name(onboard->controller_type), number);
}

// The estimator and the controller that a drone boots with.
static cf_status_t boot_selection(cf_onboard_t *onboard, const cf_provider_t *provider,
                                  void *provider_state, const cf_boot_t *boot) {
  if (!cf_estimator_exists(provider, boot->estimator)) {
    return CF_ERR_UNKNOWN;
  }
  const cf_status_t status = provider->controller_init(provider_state, boot->controller);
  if (status != CF_OK) {
    return status;
  }
  onboard->controller_type = (uint8_t)provider->controller_type(provider_state);
  cf_estimator_init(&onboard->estimator, provider, provider_state, boot->estimator, onboard->tick);
  onboard->estimator_type = onboard->estimator.type;
  tell_controller(onboard, provider);
  return CF_OK;
}

cf_status_t cf_onboard_init(cf_onboard_t *onboard, const cf_provider_t *provider,
                            void *provider_state, const cf_boot_t *boot) {
  const cf_console_t console = onboard->console;
  memset(onboard, 0, sizeof *onboard);
  onboard->console          = console;
  onboard->ext_pos_std_dev  = EXT_POS_STD_DEV;
  onboard->ext_quat_std_dev = EXT_QUAT_STD_DEV;
  onboard->supply_voltage   = SUPPLY_START;
  onboard->radio_id         = boot->radio_id;

  cf_sensors_init(&onboard->sensors);
  cf_sensors_set_trim(&onboard->sensors, boot->acc_trim_pitch, boot->acc_trim_roll);
  cf_high_level_commander_init(&onboard->high_level);
  cf_commander_init(&onboard->commander, onboard->tick);
  cf_rpyt_init(&onboard->rpyt);
  cf_cppm_init(&onboard->cppm);
  cf_peer_localization_init(&onboard->peers);
  cf_supervisor_init(&onboard->supervisor, boot->auto_arming);
  cf_power_management_init(&onboard->power, boot->platform);
  cf_health_init(&onboard->health, boot->platform);
  cf_system_variables_init(&onboard->system, boot->seed, boot->serial);
  return provider->system != NULL
             ? cf_firmware_modules_boot(onboard, provider, provider_state, boot)
             : boot_selection(onboard, provider, provider_state, boot);
}

// ------------------------------------------------------------------------- external positioning

bool cf_onboard_external_pose(cf_onboard_t *onboard, const poseMeasurement_t *pose) {
  measurement_t measurement        = {.type = MeasurementTypePose, .data.pose = *pose};
  measurement.data.pose.stdDevPos  = onboard->ext_pos_std_dev;
  measurement.data.pose.stdDevQuat = onboard->ext_quat_std_dev;
  onboard->external_pose           = measurement.data.pose;
  onboard->external_tick           = (uint16_t)onboard->tick;
  return cf_estimator_enqueue(&onboard->estimator, &measurement);
}

bool cf_onboard_external_position(cf_onboard_t *onboard, float x, float y, float z) {
  const measurement_t measurement = {
      .type          = MeasurementTypePosition,
      .data.position = {.pos    = {x, y, z},
                        .stdDev = onboard->ext_pos_std_dev,
                        .source = MeasurementSourceLocationService},
  };
  memcpy(onboard->external_pose.pos, measurement.data.position.pos,
         sizeof onboard->external_pose.pos);
  onboard->external_tick = (uint16_t)onboard->tick;
  return cf_estimator_enqueue(&onboard->estimator, &measurement);
}

// --------------------------------------------------------------------------------------- faults

const char *cf_fault_text(cf_fault_t fault) {
  switch (fault) {
    case CF_FAULT_NONE:
      return "none";
    case CF_FAULT_MOTION:
      return "the simulated motion is not finite";
    case CF_FAULT_ESTIMATE:
      return "the state estimate is not a number";
    case CF_FAULT_CONTROL:
      return "the controller's output is not a number";
    case CF_FAULT_SOFTWARE:
      return "the onboard software failed";
    case CF_FAULT_POWER:
      return "the battery was cut";
    case CF_FAULT_PILOT:
      return "its motor control failed";
  }
  return "unknown fault";
}

// cold: the loop, which may end here, is laid out and inlined as if it never did
__attribute__((cold)) void cf_onboard_fail(cf_onboard_t *onboard, cf_fault_t fault) {
  if (onboard->fault == CF_FAULT_NONE) {
    onboard->fault      = fault;
    onboard->fault_tick = onboard->tick;
    cf_console_print_line(&onboard->console, "SYS: Stopped, ", cf_fault_text(fault), NULL);
  }
  memset(&onboard->motors, 0, sizeof onboard->motors);
  onboard->supervisor.state     = supervisorStateLocked;
  onboard->supervisor.can_fly   = 0;
  onboard->supervisor.is_flying = 0;
  onboard->supervisor.is_armed  = false;
  onboard->supervisor.info      = CF_SUPERVISOR_INFO_IS_LOCKED;
}

static void fail_in_words(cf_onboard_t *onboard, cf_fault_t fault, const char *reason) {
  if (onboard->fault == CF_FAULT_NONE) {
    snprintf(onboard->failure, sizeof onboard->failure, "%s", reason);
    cf_onboard_fail(onboard, fault);
    cf_console_print_line(&onboard->console, "SYS: ", onboard->failure, NULL);
  }
}

__attribute__((cold)) void cf_onboard_fail_because(cf_onboard_t *onboard, const char *reason) {
  fail_in_words(onboard, CF_FAULT_SOFTWARE, reason);
}

__attribute__((cold)) void cf_onboard_fail_pilot(cf_onboard_t *onboard, const char *reason) {
  fail_in_words(onboard, CF_FAULT_PILOT, reason);
}

static bool is_finite_estimate(const state_t *s) {
  // a sum is finite only when all of its terms are
  const float sum = (s->position.x + s->position.y + s->position.z) +
                    (s->velocity.x + s->velocity.y + s->velocity.z) +
                    (s->attitude.roll + s->attitude.pitch + s->attitude.yaw);
  return isfinite(sum);
}

static bool is_finite_control(const control_t *control) {
  if (control->controlMode == controlModeLegacy) {
    return isfinite(control->thrust);
  }
  const float *f = control->normalizedForces;
  return isfinite(f[0] + f[1] + f[2] + f[3]);
}

// --------------------------------------------------------------------------------------- motors

static void control_motors(cf_onboard_t *onboard, const cf_provider_t *provider,
                           void *provider_state) {
  provider->power_distribution(provider_state, &onboard->control, &onboard->uncapped);
  onboard->supply_voltage +=
      SUPPLY_FILTER_GAIN * (onboard->power.voltage - onboard->supply_voltage);
  provider->battery_compensate(provider_state, &onboard->uncapped, onboard->supply_voltage,
                               &onboard->compensated);
  provider->power_cap(provider_state, &onboard->compensated, &onboard->motors);
}

// --------------------------------------------------------------------------------- the 1 kHz loop

// A changed parameter selects another estimator or controller; what really became active is read
// back, so that a client sees whether its choice exists.
static void follow_selection(cf_onboard_t *onboard, const cf_provider_t *provider,
                             void *provider_state) {
  if (onboard->estimator_type != onboard->estimator.type) {
    cf_estimator_switch_to(&onboard->estimator, provider, provider_state, onboard->estimator_type,
                           onboard->tick);
    onboard->estimator_type = onboard->estimator.type;
  }
  const int active = provider->controller_type(provider_state);
  if (onboard->controller_type != active) {
    provider->controller_init(provider_state, onboard->controller_type);
    onboard->controller_type = (uint8_t)provider->controller_type(provider_state);
    tell_controller(onboard, provider);
  }
}

static void get_setpoint(cf_onboard_t *onboard, const cf_provider_t *provider,
                         void *provider_state) {
  const uint64_t now_us = (uint64_t)onboard->tick * 1000;
  setpoint_t     planned;
  if (cf_high_level_commander_get_setpoint(&onboard->high_level, provider, provider_state,
                                           &onboard->estimate, onboard->step, now_us, &planned)) {
    cf_commander_set_setpoint(&onboard->commander, provider, provider_state, &planned,
                              COMMANDER_PRIORITY_HIGHLEVEL, onboard->tick);
  }
  cf_commander_get_setpoint(&onboard->commander, &onboard->setpoint);
}

// What parameter supervisor.infdmp asks for.
static void dump_supervisor(cf_onboard_t *onboard) {
  cf_console_print_line(&onboard->console,
                        "SUP: state: ", supervisorGetStateName(onboard->supervisor.state), NULL);
  for (int i = 0; i < CF_CONDITION_COUNT; i++) {
    const bool is_set = (onboard->supervisor.conditions & (1u << i)) != 0;
    cf_console_print_line(&onboard->console, is_set ? "SUP: [x] " : "SUP: [ ] ",
                          supervisorGetConditionName((cf_condition_t)i), NULL);
  }
}

// 25 times a second.
static void supervise(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state) {
  if (onboard->step % (RATE_MAIN_LOOP / RATE_SUPERVISOR) != 0) {
    return;
  }
  const uint64_t         now_us = (uint64_t)onboard->tick * 1000;
  cf_supervisor_inputs_t inputs = {
      .acc                 = onboard->sensors.data.acc,
      .setpoint_tick       = onboard->setpoint.timestamp,
      .now                 = onboard->tick,
      .idle_thrust         = provider->idle_thrust(provider_state),
      .planner_state       = provider->plan_state(provider_state),
      .planner_is_finished = cf_high_level_commander_is_trajectory_finished(
          &onboard->high_level, provider, provider_state, now_us),
  };
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    inputs.motor_ratio[i] = onboard->motors.list[i];
  }
  if (onboard->supervisor.infdmp != 0) {
    dump_supervisor(onboard);
  }
  const char *line = cf_supervisor_update(&onboard->supervisor, &inputs, onboard->step);
  if (line != NULL) {
    cf_console_print_line(&onboard->console, "SUP: ", line, NULL);
  }
  cf_power_management_update(&onboard->power, onboard->tick);
  cf_system_variables_update(&onboard->system);
}

// Returns whether a health test has the loop for itself.
static bool run_health_test(cf_onboard_t *onboard) {
  cf_health_t *health      = &onboard->health;
  const bool   was_shaking = cf_health_is_testing_propellers(health);
  const bool   is_running =
      cf_health_is_running(health, cf_supervisor_is_flying(&onboard->supervisor));
  if (is_running) {
    cf_health_run(health, &onboard->sensors.data.acc, onboard->power.voltage, &onboard->motors);
  }
  const bool is_shaking = cf_health_is_testing_propellers(health);
  if (is_shaking != was_shaking) {
    cf_sensors_listen_to_propellers(&onboard->sensors, is_shaking);
  }
  return is_running;
}

// One iteration, in the order of the firmware (docs/reference/control-pid.md#4).
static void iterate(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state) {
  if (run_health_test(onboard)) {
    return;
  }
  follow_selection(onboard, provider, provider_state);
  cf_estimator_update(&onboard->estimator, provider, provider_state, &onboard->estimate,
                      onboard->step, onboard->tick);
  if (!is_finite_estimate(&onboard->estimate)) {
    cf_onboard_fail(onboard, CF_FAULT_ESTIMATE);
    return;
  }

  // decided in an earlier iteration: motors start one step after the state allows them
  const bool are_motors_allowed = cf_supervisor_are_motors_allowed(&onboard->supervisor);
  cf_high_level_commander_block(&onboard->high_level, provider, provider_state,
                                !are_motors_allowed);
  get_setpoint(onboard, provider, provider_state);
  supervise(onboard, provider, provider_state);
  provider->collision_avoidance(provider_state, &onboard->setpoint, onboard->peers.peers,
                                &onboard->sensors.data, &onboard->estimate, onboard->tick);
  cf_supervisor_override_setpoint(&onboard->supervisor, &onboard->setpoint);

  if (onboard->held_control.is_on) {
    onboard->control = onboard->held_control.control;
  } else {
    provider->controller(provider_state, &onboard->control, &onboard->setpoint,
                         &onboard->sensors.data, &onboard->estimate, onboard->step);
  }
  onboard->control_yaw = onboard->control.yaw;
  if (!is_finite_control(&onboard->control)) {
    cf_onboard_fail(onboard, CF_FAULT_CONTROL);
    return;
  }

  if (are_motors_allowed) {
    control_motors(onboard, provider, provider_state);
  } else {
    memset(&onboard->motors, 0, sizeof onboard->motors);
  }
  provider->motor_override(provider_state, onboard->power.voltage, &onboard->motors);
  onboard->step++;
}

static void sample_sensors(cf_onboard_t *onboard, const cf_hardware_t *hardware) {
  cf_sensors_update(&onboard->sensors, &hardware->gyro, &hardware->acc, onboard->tick);
  const measurement_t gyro = {.type                = MeasurementTypeGyroscope,
                              .data.gyroscope.gyro = onboard->sensors.data.gyro};
  const measurement_t acc  = {.type                  = MeasurementTypeAcceleration,
                              .data.acceleration.acc = onboard->sensors.data.acc};
  cf_estimator_enqueue(&onboard->estimator, &gyro);
  cf_estimator_enqueue(&onboard->estimator, &acc);

  if (hardware->has_pressure) {
    cf_sensors_update_baro(&onboard->sensors, hardware->pressure, hardware->temperature);
    const measurement_t baro = {.type                = MeasurementTypeBarometer,
                                .data.barometer.baro = onboard->sensors.data.baro};
    cf_estimator_enqueue(&onboard->estimator, &baro);
  }
}

static void count_rate(cf_onboard_t *onboard) {
  const uint32_t elapsed = onboard->tick - onboard->rate_tick;
  if (elapsed >= LOOP_RATE_INTERVAL) {
    onboard->loop_rate = (float)(onboard->step - onboard->rate_step) * 1000.0f / (float)elapsed;
    onboard->rate_tick = onboard->tick;
    onboard->rate_step = onboard->step;
  }
}

// The same for a provider that brings more than the algorithms.
static void fly_firmware_modules(cf_onboard_t *onboard, const cf_provider_t *provider,
                                 void *provider_state, bool are_calibrated) {
  const bool is_held =
      !provider->system->has_own_loop && are_calibrated && run_health_test(onboard);
  cf_firmware_modules_tick(onboard, provider, provider_state, are_calibrated, is_held);
  if (!is_finite_estimate(&onboard->estimate)) {
    cf_onboard_fail(onboard, CF_FAULT_ESTIMATE);
  } else if (!is_finite_control(&onboard->control)) {
    cf_onboard_fail(onboard, CF_FAULT_CONTROL);
  }
  if (onboard->fault != CF_FAULT_NONE) {
    cf_onboard_fail(onboard, onboard->fault);
  }
}

void cf_onboard_tick(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state,
                     const cf_hardware_t *hardware) {
  onboard->tick++;
  count_rate(onboard);
  cf_power_management_measure(&onboard->power, hardware->battery_voltage);
  if (onboard->fault != CF_FAULT_NONE || onboard->tick <= SENSORS_START_UP) {
    return;
  }

  // the loop begins with the sample after those that it was calibrated with
  const bool is_calibrated = cf_sensors_are_calibrated(&onboard->sensors);
  sample_sensors(onboard, hardware);
  if (provider->system != NULL) {
    fly_firmware_modules(onboard, provider, provider_state, is_calibrated);
    return;
  }
  if (onboard->step == 0) {
    if (!is_calibrated) {
      return;
    }
    onboard->step = 1;
  }
  iterate(onboard, provider, provider_state);
  if (onboard->fault == CF_FAULT_NONE) {
    // the estimator's task runs when the loop has finished: its result is seen one step later
    cf_estimator_run(&onboard->estimator, provider, provider_state, onboard->tick,
                     cf_supervisor_is_flying(&onboard->supervisor));
  }
  if (onboard->fault != CF_FAULT_NONE) {
    // the provider may have failed at any place, and what came after it has set the motors
    cf_onboard_fail(onboard, onboard->fault);
  }
}
