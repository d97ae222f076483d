#include "builtin/control/controller_pid.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#include "builtin/control/cap_angle.h"
#include "variable_row.h"

#define PI_F 3.14159265358979323846f
#define ATTITUDE_UPDATE_DT 0.002f  // [s]

// an attitude or position tick at this step of the 1 kHz loop
static bool is_due(int rate, stabilizerStep_t step) {
  return step % (stabilizerStep_t)(RATE_MAIN_LOOP / rate) == 0;
}

static float in_degrees(float angle) {
  return (180.0f / PI_F) * angle;
}

static float in_radians(float angle) {
  return (PI_F / 180.0f) * angle;
}

cf_status_t cf_controller_pid_init(cf_controller_pid_t *pid, cf_platform_t platform) {
  const cf_platform_defaults_t *defaults = cf_platform_defaults(platform);
  if (defaults == NULL) {
    return CF_ERR_UNKNOWN;
  }
  *pid = (cf_controller_pid_t){0};
  cf_attitude_controller_init(&pid->attitude, defaults);
  cf_position_controller_init(&pid->position, defaults);
  return CF_OK;
}

void cf_controller_pid_reinit(cf_controller_pid_t *pid) {
  cf_position_controller_reinit(&pid->position);
}

// every loop forgets; the yaw target stays
static void reset_all(cf_controller_pid_t *pid, const state_t *state) {
  const point_t *at = &state->position;
  cf_position_controller_reset(&pid->position, at->x, at->y, at->z);
  cf_position_controller_reset_filters(&pid->position);
  cf_attitude_controller_reset(&pid->attitude, &state->attitude);
  pid->attitude_desired.roll  = state->attitude.roll;
  pid->attitude_desired.pitch = state->attitude.pitch;
}

static bool mode_changed(const setpoint_mode_t *a, const setpoint_mode_t *b) {
  return a->x != b->x || a->y != b->y || a->z != b->z || a->roll != b->roll ||
         a->pitch != b->pitch || a->yaw != b->yaw || a->quat != b->quat;
}

static float quaternion_yaw(const quaternion_t *q) {
  return atan2f(2.0f * (q->w * q->z + q->x * q->y), 1.0f - 2.0f * (q->y * q->y + q->z * q->z));
}

// turns the yaw target at the given rate [deg/s], at most yaw_max_delta away from the vehicle
static float turned_yaw_target(const cf_controller_pid_t *pid, float yaw_rate, float yaw) {
  const float target = cf_cap_angle(pid->attitude_desired.yaw + yaw_rate * ATTITUDE_UPDATE_DT);

  const float max_delta = pid->attitude.yaw_max_delta;
  if (max_delta != 0.0f) {
    const float delta = cf_cap_angle(target - yaw);
    if (delta > max_delta) {
      return yaw + max_delta;
    }
    if (delta < -max_delta) {
      return yaw - max_delta;
    }
  }
  return target;
}

static void update_yaw_target(cf_controller_pid_t *pid, const setpoint_t *setpoint, float yaw) {
  float target = pid->attitude_desired.yaw;
  if (setpoint->mode.yaw == modeVelocity) {
    target = turned_yaw_target(pid, setpoint->attitudeRate.yaw, yaw);
  } else if (setpoint->mode.yaw == modeAbs) {
    target = setpoint->attitude.yaw;
  } else if (setpoint->mode.quat == modeAbs) {
    target = in_degrees(quaternion_yaw(&setpoint->attitudeQuaternion));
  }
  pid->attitude_desired.yaw = cf_cap_angle(target);
}

// angle and rate loops, with the parts of the setpoint that bypass the outer ones
static void attitude_tick(cf_controller_pid_t *pid, control_t *control, const setpoint_t *setpoint,
                          const sensorData_t *sensors, const state_t *state) {
  const setpoint_mode_t *mode = &setpoint->mode;
  if (mode->z == modeDisable) {
    pid->actuator_thrust = setpoint->thrust;
  }
  if (mode->x == modeDisable || mode->y == modeDisable) {
    pid->attitude_desired.roll  = setpoint->attitude.roll;
    pid->attitude_desired.pitch = setpoint->attitude.pitch;
  }

  cf_attitude_controller_correct_attitude(&pid->attitude, &state->attitude, &pid->attitude_desired,
                                          &pid->rate_desired);

  // the angle loops have run all the same: they keep integrating
  if (mode->roll == modeVelocity) {
    pid->rate_desired.roll = setpoint->attitudeRate.roll;
  }
  if (mode->pitch == modeVelocity) {
    pid->rate_desired.pitch = setpoint->attitudeRate.pitch;
  }

  // legacy pitch: the gyro's y axis is right-handed
  const Axis3f    *gyro = &sensors->gyro;
  const attitude_t rate = {.roll = gyro->x, .pitch = -gyro->y, .yaw = gyro->z};
  if (!cf_attitude_controller_correct_rate(&pid->attitude, &rate, &pid->rate_desired)) {
    // whole numbers cannot show it, the thrust can: the loop around stops the drone
    pid->actuator_thrust = NAN;
  }

  control->roll  = pid->attitude.roll_output;
  control->pitch = pid->attitude.pitch_output;
  control->yaw   = (int16_t)-pid->attitude.yaw_output;

  pid->cmd_thrust = control->thrust;
  pid->cmd_roll   = (float)control->roll;
  pid->cmd_pitch  = (float)control->pitch;
  pid->cmd_yaw    = (float)control->yaw;
  pid->r_roll     = in_radians(gyro->x);
  pid->r_pitch    = -in_radians(gyro->y);
  pid->r_yaw      = in_radians(gyro->z);
  pid->accelz     = sensors->acc.z;
}

// no thrust: motors off and nothing remembered, so that the next start is a fresh one
static void rest(cf_controller_pid_t *pid, control_t *control, const state_t *state) {
  control->thrust = 0.0f;
  control->roll   = 0;
  control->pitch  = 0;
  control->yaw    = 0;

  pid->cmd_thrust = 0.0f;
  pid->cmd_roll   = 0.0f;
  pid->cmd_pitch  = 0.0f;
  pid->cmd_yaw    = 0.0f;

  reset_all(pid, state);
  pid->attitude_desired.yaw = state->attitude.yaw;
}

void cf_controller_pid_update(cf_controller_pid_t *pid, control_t *control,
                              const setpoint_t *setpoint, const sensorData_t *sensors,
                              const state_t *state, stabilizerStep_t step) {
  control->controlMode = controlModeLegacy;

  if (mode_changed(&setpoint->mode, &pid->previous_mode)) {
    reset_all(pid, state);
    pid->previous_mode = setpoint->mode;
  }

  if (is_due(ATTITUDE_RATE, step)) {
    update_yaw_target(pid, setpoint, state->attitude.yaw);
  }
  if (is_due(POSITION_RATE, step)) {
    cf_position_controller_update(&pid->position, &pid->actuator_thrust, &pid->attitude_desired,
                                  setpoint, state);
  }
  if (is_due(ATTITUDE_RATE, step)) {
    attitude_tick(pid, control, setpoint, sensors, state);
  }

  control->thrust = pid->actuator_thrust;
  if (control->thrust == 0.0f) {
    rest(pid, control, state);
  }
}

#define LOG(name_, member_) CF_ROW("controller", name_, FLOAT, 0, cf_controller_pid_t, member_)

static const cf_variable_t LOGS[] = {
    LOG("cmd_thrust", cmd_thrust),
    LOG("cmd_roll", cmd_roll),
    LOG("cmd_pitch", cmd_pitch),
    LOG("cmd_yaw", cmd_yaw),
    LOG("r_roll", r_roll),
    LOG("r_pitch", r_pitch),
    LOG("r_yaw", r_yaw),
    LOG("accelz", accelz),
    LOG("actuatorThrust", actuator_thrust),
    LOG("roll", attitude_desired.roll),
    LOG("pitch", attitude_desired.pitch),
    LOG("yaw", attitude_desired.yaw),
    LOG("rollRate", rate_desired.roll),
    LOG("pitchRate", rate_desired.pitch),
    LOG("yawRate", rate_desired.yaw),
};

cf_variables_t cf_controller_pid_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = sizeof(LOGS) / sizeof(LOGS[0])};
}
