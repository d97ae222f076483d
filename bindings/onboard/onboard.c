#include "onboard/onboard.h"

#include <math.h>
#include <string.h>

#define SENSORS_START_UP 1000     // [ms], estimators dossier section 12.1
#define SUPPLY_START 4.2f         // [V], control-pid dossier section 14
#define SUPPLY_FILTER_GAIN 0.01f  // per control of the motors
#define EXT_POS_STD_DEV 0.01f     // [m]
#define EXT_QUAT_STD_DEV 4.5e-3f  // [rad]

// Chooses an estimator as the firmware does; only the Kalman filter exists so far.
static bool select_estimator(cf_onboard_t *onboard, int type) {
  if (type != StateEstimatorTypeAutoSelect && type != StateEstimatorTypeKalman) {
    return false;
  }
  onboard->estimator_type = StateEstimatorTypeKalman;
  return true;
}

cf_status_t cf_onboard_init(cf_onboard_t *onboard, const cf_provider_t *provider,
                            void *provider_state, const cf_boot_t *boot) {
  memset(onboard, 0, sizeof *onboard);
  onboard->ext_pos_std_dev  = EXT_POS_STD_DEV;
  onboard->ext_quat_std_dev = EXT_QUAT_STD_DEV;
  onboard->supply_voltage   = SUPPLY_START;

  if (!select_estimator(onboard, boot->estimator)) {
    return CF_ERR_UNKNOWN;
  }
  const cf_status_t status = provider->controller_init(provider_state, boot->controller);
  if (status != CF_OK) {
    return status;
  }
  onboard->controller_type = (uint8_t)provider->controller_type(provider_state);

  cf_sensors_init(&onboard->sensors);
  cf_estimator_init(&onboard->estimator, provider, provider_state, onboard->tick);
  cf_high_level_commander_init(&onboard->high_level);
  cf_commander_init(&onboard->commander, onboard->tick);
  cf_rpyt_init(&onboard->rpyt);
  cf_supervisor_init(&onboard->supervisor, boot->auto_arming);
  return CF_OK;
}

// ------------------------------------------------------------------------- external positioning

bool cf_onboard_external_pose(cf_onboard_t *onboard, const poseMeasurement_t *pose) {
  measurement_t measurement        = {.type = MeasurementTypePose, .data.pose = *pose};
  measurement.data.pose.stdDevPos  = onboard->ext_pos_std_dev;
  measurement.data.pose.stdDevQuat = onboard->ext_quat_std_dev;
  onboard->external_pose           = measurement.data.pose;
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
  }
  return "unknown fault";
}

void cf_onboard_fail(cf_onboard_t *onboard, cf_fault_t fault) {
  if (onboard->fault == CF_FAULT_NONE) {
    onboard->fault      = fault;
    onboard->fault_tick = onboard->tick;
  }
  memset(&onboard->motors, 0, sizeof onboard->motors);
  onboard->supervisor.state    = supervisorStateLocked;
  onboard->supervisor.can_fly  = 0;
  onboard->supervisor.is_armed = false;
  onboard->supervisor.info     = CF_SUPERVISOR_INFO_IS_LOCKED;
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
      SUPPLY_FILTER_GAIN * (onboard->battery_voltage - onboard->supply_voltage);
  provider->battery_compensate(provider_state, &onboard->uncapped, onboard->supply_voltage,
                               &onboard->compensated);
  provider->power_cap(provider_state, &onboard->compensated, &onboard->motors);
}

// --------------------------------------------------------------------------------- the 1 kHz loop

// A changed parameter selects another estimator or controller; what really became active is read
// back, so that a client sees whether its choice exists.
static void follow_selection(cf_onboard_t *onboard, const cf_provider_t *provider,
                             void *provider_state) {
  if (onboard->estimator_type != StateEstimatorTypeKalman) {
    onboard->estimator_type = StateEstimatorTypeKalman;
  }
  const int active = provider->controller_type(provider_state);
  if (onboard->controller_type != active) {
    provider->controller_init(provider_state, onboard->controller_type);
    onboard->controller_type = (uint8_t)provider->controller_type(provider_state);
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

static void supervise(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state) {
  if (onboard->step % (RATE_MAIN_LOOP / RATE_SUPERVISOR) == 0) {
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
    cf_supervisor_update(&onboard->supervisor, &inputs, onboard->step);
  }
  cf_supervisor_override_setpoint(&onboard->supervisor, &onboard->setpoint);
}

// One iteration, in the order of the firmware (control-pid dossier section 4).
static void iterate(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state) {
  follow_selection(onboard, provider, provider_state);
  cf_estimator_get(&onboard->estimator, &onboard->estimate);
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

  provider->controller(provider_state, &onboard->control, &onboard->setpoint,
                       &onboard->sensors.data, &onboard->estimate, onboard->step);
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
  provider->motor_override(provider_state, onboard->battery_voltage, &onboard->motors);
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
}

void cf_onboard_tick(cf_onboard_t *onboard, const cf_provider_t *provider, void *provider_state,
                     const cf_hardware_t *hardware) {
  onboard->tick++;
  onboard->battery_voltage   = hardware->battery_voltage;
  onboard->battery_millivolt = (uint16_t)(hardware->battery_voltage * 1000.0f);
  if (onboard->fault != CF_FAULT_NONE || onboard->tick <= SENSORS_START_UP) {
    return;
  }

  sample_sensors(onboard, hardware);
  if (onboard->step == 0) {
    if (!cf_sensors_are_calibrated(&onboard->sensors)) {
      return;
    }
    onboard->step = 1;
  }
  iterate(onboard, provider, provider_state);
  if (onboard->fault != CF_FAULT_NONE) {
    return;
  }

  // the estimator's task runs when the loop has finished: its result is seen one step later
  cf_estimator_run(&onboard->estimator, provider, provider_state, onboard->tick,
                   cf_supervisor_is_flying(&onboard->supervisor));
}
