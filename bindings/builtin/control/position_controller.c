#include "builtin/control/position_controller.h"

#include <math.h>
#include <stddef.h>

#include "api/num.h"
#include "variable_row.h"

#define POSITION_UPDATE_DT 0.01f  // [s]

#define PI_F 3.14159265358979323846f
#define OVERHEAD 1.10f            // the PIDs may go past the limits by this factor
#define SLOWEST_CLIMB_LIMIT 0.5f  // [m/s]
#define THRUST_SCALE 1000.0f      // counts per unit of the vertical loop
#define LARGEST_CLIMB_OUTPUT (32767.0f / THRUST_SCALE)
#define FULL_THRUST 65535.0f

static void set_gains(PidObject *pid, const cf_pid_gains_t *gains) {
  pidSetKp(pid, gains->kp);
  pidSetKi(pid, gains->ki);
  pidSetKd(pid, gains->kd);
  pidSetKff(pid, gains->kff);
}

void cf_position_controller_init(cf_position_controller_t     *position,
                                 const cf_platform_defaults_t *defaults) {
  *position = (cf_position_controller_t){
      .roll_max           = defaults->roll_max,
      .pitch_max          = defaults->pitch_max,
      .velocity_x_max     = defaults->velocity_x_max,
      .velocity_y_max     = defaults->velocity_y_max,
      .velocity_z_max     = defaults->velocity_z_max,
      .thrust_base        = defaults->thrust_base,
      .thrust_min         = defaults->thrust_min,
      .position_xy_filter = defaults->position_xy_filter,
      .position_z_filter  = defaults->position_z_filter,
      .velocity_xy_filter = defaults->velocity_xy_filter,
      .velocity_z_filter  = defaults->velocity_z_filter,
  };

  set_gains(&position->x, &defaults->x);
  set_gains(&position->y, &defaults->y);
  set_gains(&position->z, &defaults->z);
  set_gains(&position->vx, &defaults->vx);
  set_gains(&position->vy, &defaults->vy);
  set_gains(&position->vz, &defaults->vz);
  cf_position_controller_reinit(position);
}

static void reinit_pid(PidObject *pid, cf_pid_filter_t filter) {
  pidInit(pid, pid->desired, pid->kp, pid->ki, pid->kd, pid->kff, POSITION_UPDATE_DT,
          (float)POSITION_RATE, filter.cutoff, filter.enabled);
}

void cf_position_controller_reinit(cf_position_controller_t *position) {
  reinit_pid(&position->x, position->position_xy_filter);
  reinit_pid(&position->y, position->position_xy_filter);
  reinit_pid(&position->z, position->position_z_filter);
  reinit_pid(&position->vx, position->velocity_xy_filter);
  reinit_pid(&position->vy, position->velocity_xy_filter);
  reinit_pid(&position->vz, position->velocity_z_filter);
}

static float run(PidObject *pid, float measured, float desired) {
  pidSetDesired(pid, desired);
  return pidUpdate(pid, measured, false);
}

// the yaw of the vehicle, with which world and yaw-aligned frame differ
typedef struct {
  float cos_yaw;
  float sin_yaw;
} heading_t;

static heading_t heading(const state_t *state) {
  const float yaw = state->attitude.yaw * PI_F / 180.0f;
  return (heading_t){.cos_yaw = cosf(yaw), .sin_yaw = sinf(yaw)};
}

static float body_x(heading_t h, float x, float y) {
  return x * h.cos_yaw + y * h.sin_yaw;
}

static float body_y(heading_t h, float x, float y) {
  return -x * h.sin_yaw + y * h.cos_yaw;
}

// velocity [m/s], yaw-aligned -> lean [deg] and thrust [counts]
static void velocity_loop(cf_position_controller_t *position, heading_t h, float *thrust,
                          attitude_t *attitude, const Axis3f *velocity, const state_t *state) {
  const float pitch_max = position->pitch_max;
  const float roll_max  = position->roll_max;

  position->vx.outputLimit = pitch_max * OVERHEAD;
  position->vy.outputLimit = roll_max * OVERHEAD;
  position->vz.outputLimit = LARGEST_CLIMB_OUTPUT;

  position->body_vx = body_x(h, state->velocity.x, state->velocity.y);
  position->body_vy = body_y(h, state->velocity.x, state->velocity.y);

  // nose up drives backwards, right side down drives to the right
  const float pitch = -run(&position->vx, position->body_vx, velocity->x);
  const float roll  = -run(&position->vy, position->body_vy, velocity->y);
  attitude->roll    = constrain(roll, -roll_max, roll_max);
  attitude->pitch   = constrain(pitch, -pitch_max, pitch_max);

  const float climb  = run(&position->vz, state->velocity.z, velocity->z);
  const float wanted = climb * THRUST_SCALE + (float)position->thrust_base;
  const float lowest = (float)position->thrust_min;
  *thrust            = constrain(wanted < lowest ? lowest : wanted, 0.0f, FULL_THRUST);
}

void cf_position_controller_update_velocity(cf_position_controller_t *position, float *thrust,
                                            attitude_t *attitude, const Axis3f *velocity,
                                            const state_t *state) {
  velocity_loop(position, heading(state), thrust, attitude, velocity, state);
}

void cf_position_controller_update(cf_position_controller_t *position, float *thrust,
                                   attitude_t *attitude, const setpoint_t *setpoint,
                                   const state_t *state) {
  const float climb_max = position->velocity_z_max > SLOWEST_CLIMB_LIMIT ? position->velocity_z_max
                                                                         : SLOWEST_CLIMB_LIMIT;
  position->x.outputLimit = position->velocity_x_max * OVERHEAD;
  position->y.outputLimit = position->velocity_y_max * OVERHEAD;
  position->z.outputLimit = climb_max * OVERHEAD;

  const heading_t   h    = heading(state);
  const point_t    *goal = &setpoint->position;
  const velocity_t *v    = &setpoint->velocity;

  position->body_x = body_x(h, state->position.x, state->position.y);
  position->body_y = body_y(h, state->position.x, state->position.y);

  // each axis: toward the goal, or at the given velocity, turned into this frame where needed
  Axis3f velocity = {.axis = {v->x, v->y, v->z}};
  if (setpoint->mode.x == modeAbs) {
    velocity.x = run(&position->x, position->body_x, body_x(h, goal->x, goal->y));
  } else if (!setpoint->velocity_body) {
    velocity.x = body_x(h, v->x, v->y);
  }
  if (setpoint->mode.y == modeAbs) {
    velocity.y = run(&position->y, position->body_y, body_y(h, goal->x, goal->y));
  } else if (!setpoint->velocity_body) {
    velocity.y = body_y(h, v->x, v->y);
  }
  if (setpoint->mode.z == modeAbs) {
    velocity.z = run(&position->z, state->position.z, goal->z);
  }

  velocity_loop(position, h, thrust, attitude, &velocity, state);
}

void cf_position_controller_reset(cf_position_controller_t *position, float x, float y, float z) {
  pidReset(&position->x, x);
  pidReset(&position->y, y);
  pidReset(&position->z, z);
  pidReset(&position->vx, 0.0f);
  pidReset(&position->vy, 0.0f);
  pidReset(&position->vz, 0.0f);
}

// The frequencies of these filters have no parameter, so the coefficients are still those of init;
// computing them again (the controller resets at 1 kHz while the thrust is zero) would cost more
// than the whole cascade.
static void clear_filter(PidObject *pid) {
  pid->dFilter.delay_element_1 = 0.0f;
  pid->dFilter.delay_element_2 = 0.0f;
}

void cf_position_controller_reset_filters(cf_position_controller_t *position) {
  clear_filter(&position->x);
  clear_filter(&position->y);
  clear_filter(&position->z);
  clear_filter(&position->vx);
  clear_filter(&position->vy);
  clear_filter(&position->vz);
}

#define PARAMETER(group_, name_, type_, member_) \
  CF_ROW(group_, name_, type_, CF_PERSISTENT, cf_position_controller_t, member_)

#define GAINS(group_, axis_, kff_name_, pid_)                                                   \
  PARAMETER(group_, axis_ "Kp", FLOAT, pid_.kp), PARAMETER(group_, axis_ "Ki", FLOAT, pid_.ki), \
      PARAMETER(group_, axis_ "Kd", FLOAT, pid_.kd),                                            \
      PARAMETER(group_, axis_ kff_name_, FLOAT, pid_.kff)

// the two groups spell the last gain differently
static const cf_variable_t PARAMETERS[] = {
    GAINS("velCtlPid", "vx", "KFF", vx),
    GAINS("velCtlPid", "vy", "KFF", vy),
    GAINS("velCtlPid", "vz", "KFF", vz),

    GAINS("posCtlPid", "x", "Kff", x),
    GAINS("posCtlPid", "y", "Kff", y),
    GAINS("posCtlPid", "z", "Kff", z),
    PARAMETER("posCtlPid", "thrustBase", UINT16, thrust_base),
    PARAMETER("posCtlPid", "thrustMin", UINT16, thrust_min),
    PARAMETER("posCtlPid", "rLimit", FLOAT, roll_max),
    PARAMETER("posCtlPid", "pLimit", FLOAT, pitch_max),
    PARAMETER("posCtlPid", "xVelMax", FLOAT, velocity_x_max),
    PARAMETER("posCtlPid", "yVelMax", FLOAT, velocity_y_max),
    PARAMETER("posCtlPid", "zVelMax", FLOAT, velocity_z_max),
};

cf_variables_t cf_position_controller_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = sizeof(PARAMETERS) / sizeof(PARAMETERS[0])};
}

#define LOG(name_, member_) CF_ROW("posCtl", name_, FLOAT, 0, cf_position_controller_t, member_)

#define TERMS(axis_, pid_)                                                         \
  LOG(axis_ "p", pid_.outP), LOG(axis_ "i", pid_.outI), LOG(axis_ "d", pid_.outD), \
      LOG(axis_ "ff", pid_.outFF)

static const cf_variable_t LOGS[] = {
    LOG("targetVX", vx.desired),
    LOG("targetVY", vy.desired),
    LOG("targetVZ", vz.desired),
    LOG("targetX", x.desired),
    LOG("targetY", y.desired),
    LOG("targetZ", z.desired),

    LOG("bodyVX", body_vx),
    LOG("bodyVY", body_vy),
    LOG("bodyX", body_x),
    LOG("bodyY", body_y),

    TERMS("X", x),
    TERMS("Y", y),
    TERMS("Z", z),
    TERMS("VX", vx),
    TERMS("VY", vy),
    TERMS("VZ", vz),
};

cf_variables_t cf_position_controller_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = sizeof(LOGS) / sizeof(LOGS[0])};
}
