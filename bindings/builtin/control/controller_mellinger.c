#include "builtin/control/controller_mellinger.h"

#include <math.h>
#include <stddef.h>

#include "convert.h"
#include "variable_row.h"

#define GRAVITY 9.81f              // [m/s^2]
#define DT (1.0f / ATTITUDE_RATE)  // [s]
#define MAX_MOMENT 32000.0f        // [counts]

cf_status_t cf_controller_mellinger_init(controllerMellinger_t *mellinger, cf_platform_t platform) {
  const cf_platform_facts_t *facts = cf_platform_facts(platform);
  if (facts == NULL) {
    return CF_ERR_UNKNOWN;
  }
  *mellinger = (controllerMellinger_t){
      .mass         = facts->mass,
      .massThrust   = 132000.0f,
      .kp_xy        = 0.4f,
      .kd_xy        = 0.2f,
      .ki_xy        = 0.05f,
      .i_range_xy   = 2.0f,
      .kp_z         = 1.25f,
      .kd_z         = 0.4f,
      .ki_z         = 0.05f,
      .i_range_z    = 0.4f,
      .kR_xy        = 70000.0f,
      .kw_xy        = 20000.0f,
      .ki_m_xy      = 0.0f,
      .i_range_m_xy = 1.0f,
      .kR_z         = 60000.0f,
      .kw_z         = 12000.0f,
      .ki_m_z       = 500.0f,
      .i_range_m_z  = 1500.0f,
      .kd_omega_rp  = 200.0f,
  };
  return CF_OK;
}

void controllerMellingerInit(controllerMellinger_t *self) {
  cf_controller_mellinger_init(self, CF_PLATFORM_CF2);
}

void controllerMellingerReset(controllerMellinger_t *self) {
  self->i_error_x   = 0.0f;
  self->i_error_y   = 0.0f;
  self->i_error_z   = 0.0f;
  self->i_error_m_x = 0.0f;
  self->i_error_m_y = 0.0f;
  self->i_error_m_z = 0.0f;
}

bool controllerMellingerTest(controllerMellinger_t *self) {
  (void)self;
  return true;
}

// ---------------------------------------------------------------------------------- desired force

static void integrate(float *integral, float error, float range) {
  *integral = clamp(*integral + error * DT, -range, range);
}

// [deg], legacy yaw equals the right-handed one
static float desired_yaw(const setpoint_t *setpoint, const state_t *state) {
  if (setpoint->mode.yaw == modeVelocity) {
    // relative to the present yaw: a turn is not integrated
    return state->attitude.yaw + setpoint->attitudeRate.yaw * DT;
  }
  if (setpoint->mode.yaw == modeAbs) {
    return setpoint->attitude.yaw;
  }
  if (setpoint->mode.quat == modeAbs) {
    const quaternion_t *q = &setpoint->attitudeQuaternion;
    return degrees(quat2rpy(mkquat(q->x, q->y, q->z, q->w)).z);
  }
  return 0.0f;
}

// [N], to follow position, velocity and acceleration
static struct vec tracking_force(const controllerMellinger_t *self, const acc_t *acceleration,
                                 struct vec r_error, struct vec v_error) {
  return mkvec(self->mass * acceleration->x + self->kp_xy * r_error.x + self->kd_xy * v_error.x +
                   self->ki_xy * self->i_error_x,
               self->mass * acceleration->y + self->kp_xy * r_error.y + self->kd_xy * v_error.y +
                   self->ki_xy * self->i_error_y,
               self->mass * (acceleration->z + GRAVITY) + self->kp_z * r_error.z +
                   self->kd_z * v_error.z + self->ki_z * self->i_error_z);
}

// [N], to hold the height
static struct vec level_force(const controllerMellinger_t *self, float z_error, float vz_error) {
  return mkvec(0.0f, 0.0f,
               self->mass * GRAVITY + self->kp_z * z_error + self->kd_z * vz_error +
                   self->ki_z * self->i_error_z);
}

// Axes as columns: z along the force, x as near to the heading [deg] as that allows.
static struct mat33 axes_of(struct vec force, float yaw) {
  const struct vec z       = vnormalize(force);
  const struct vec heading = mkvec(cosf(radians(yaw)), sinf(radians(yaw)), 0.0f);
  const struct vec y       = vnormalize(vcross(z, heading));
  return mcolumns(vcross(y, z), y, z);
}

static struct mat33 axes_of_angles(const attitude_t *attitude, float yaw) {
  // legacy pitch: positive lifts the nose
  const struct vec rpy = mkvec(radians(attitude->roll), -radians(attitude->pitch), radians(yaw));
  return quat2rotmat(rpy2quat(rpy));
}

static bool is_manual(const setpoint_mode_t *mode) {
  return mode->pitch == modeAbs && mode->roll == modeAbs && mode->z == modeDisable;
}

// Returns the desired axes as columns and writes the thrust [N] along the present z axis, which is
// 0 when the pilot has the thrust.
static struct mat33 desired_axes(controllerMellinger_t *self, const setpoint_t *setpoint,
                                 const state_t *state, struct quat q, float *thrust) {
  const point_t    *r = &state->position;
  const velocity_t *v = &state->velocity;
  const struct vec  r_error =
      vsub(mkvec(setpoint->position.x, setpoint->position.y, setpoint->position.z),
           mkvec(r->x, r->y, r->z));
  const struct vec v_error =
      vsub(mkvec(setpoint->velocity.x, setpoint->velocity.y, setpoint->velocity.z),
           mkvec(v->x, v->y, v->z));

  // in every mode, also where the integrals are not used
  integrate(&self->i_error_z, r_error.z, self->i_range_z);
  integrate(&self->i_error_x, r_error.x, self->i_range_xy);
  integrate(&self->i_error_y, r_error.y, self->i_range_xy);

  const float      yaw    = desired_yaw(setpoint, state);
  const struct vec z_axis = mcolumn(quat2rotmat(q), 2);
  *thrust                 = 0.0f;

  // mode.y and mode.z have no say
  if (setpoint->mode.x == modeAbs) {
    const struct vec force = tracking_force(self, &setpoint->acceleration, r_error, v_error);
    *thrust                = vdot(force, z_axis);
    return axes_of(force, yaw);
  }
  if (is_manual(&setpoint->mode)) {
    return axes_of_angles(&setpoint->attitude, yaw);
  }
  const struct vec force = level_force(self, r_error.z, v_error.z);
  *thrust                = vdot(force, z_axis);
  return axes_of(force, state->attitude.yaw);
}

// -------------------------------------------------------------------------------- desired moments

// The three numbers of E = Rd' R - R' Rd: E(2,1), -E(0,2), E(1,0), for R of the quaternion and Rd
// with the columns a, b, c. Written out, since a product of matrices rounds differently.
static struct vec rotation_error(struct quat q, struct mat33 desired) {
  const struct vec a = mcolumn(desired, 0);
  const struct vec b = mcolumn(desired, 1);
  const struct vec c = mcolumn(desired, 2);
  const float      x = q.x;
  const float      y = q.y;
  const float      z = q.z;
  const float      w = q.w;

  const float e_x = (-1.0f + 2.0f * fsqr(x) + 2.0f * fsqr(y)) * b.z + c.y -
                    2.0f * (x * b.x * z + y * b.y * z - x * y * c.x + fsqr(x) * c.y +
                            fsqr(z) * c.y - y * z * c.z) +
                    2.0f * w * (-(y * b.x) - z * c.x + x * (b.y + c.z));
  const float e_y =
      a.z - c.x -
      2.0f * (fsqr(x) * a.z + y * (a.z * y - a.y * z) - (fsqr(y) + fsqr(z)) * c.x +
              x * (-(a.x * z) + y * c.y + z * c.z) + w * (x * a.y + z * c.y - y * (a.x + c.z)));
  const float e_z = b.x - 2.0f * (y * (x * a.x + y * b.x - x * b.y) + w * (x * a.z + y * b.z)) +
                    2.0f * (-(a.z * y) + w * (a.x + b.y) + x * b.z) * z - 2.0f * b.x * fsqr(z) +
                    a.y * (-1.0f + 2.0f * fsqr(x) + 2.0f * fsqr(z));
  return mkvec(e_x, -e_y, e_z);
}

// Error of the angular acceleration about x and y [rad/s^2], from the rates of two calls.
static struct vec acceleration_error(controllerMellinger_t *self, struct vec omega,
                                     const attitude_t *rate) {
  const float roll  = radians(rate->roll);
  const float pitch = radians(rate->pitch);
  struct vec  error = vzero();

  // after a rate that was NaN there is none
  if (!isnan(self->prev_omega_roll)) {
    error.x = ((roll - self->prev_setpoint_omega_roll) - (omega.x - self->prev_omega_roll)) / DT;
    error.y =
        (-(pitch - self->prev_setpoint_omega_pitch) - (omega.y - self->prev_omega_pitch)) / DT;
  }

  self->prev_omega_roll           = omega.x;
  self->prev_omega_pitch          = omega.y;
  self->prev_setpoint_omega_roll  = roll;
  self->prev_setpoint_omega_pitch = pitch;
  return error;
}

// [counts], about x and z right-handed, about y the legacy way
static struct vec moments(controllerMellinger_t *self, struct vec r_error, struct vec omega,
                          const attitude_t *rate) {
  const struct vec omega_desired =
      mkvec(radians(rate->roll), -radians(rate->pitch), radians(rate->yaw));
  const struct vec omega_error = vsub(omega_desired, omega);
  const struct vec accel_error = acceleration_error(self, omega, rate);

  integrate(&self->i_error_m_x, -r_error.x, self->i_range_m_xy);
  integrate(&self->i_error_m_y, -r_error.y, self->i_range_m_xy);
  integrate(&self->i_error_m_z, -r_error.z, self->i_range_m_z);

  return mkvec(
      -self->kR_xy * r_error.x + self->kw_xy * omega_error.x + self->ki_m_xy * self->i_error_m_x +
          self->kd_omega_rp * accel_error.x,
      -self->kR_xy * r_error.y + self->kw_xy * omega_error.y + self->ki_m_xy * self->i_error_m_y +
          self->kd_omega_rp * accel_error.y,
      -self->kR_z * r_error.z + self->kw_z * omega_error.z + self->ki_m_z * self->i_error_m_z);
}

static int16_t in_counts(float moment) {
  return (int16_t)cf_to_int32(clamp(moment, -MAX_MOMENT, MAX_MOMENT));
}

void controllerMellinger(controllerMellinger_t *self, control_t *control,
                         const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep) {
  control->controlMode = controlModeLegacy;
  if (stabilizerStep % (RATE_MAIN_LOOP / ATTITUDE_RATE) != 0) {
    return;
  }

  const quaternion_t *attitude = &state->attitudeQuaternion;
  const struct quat   q        = mkquat(attitude->x, attitude->y, attitude->z, attitude->w);
  const Axis3f       *gyro     = &sensors->gyro;

  float              force;
  const struct mat33 desired = desired_axes(self, setpoint, state, q, &force);
  const struct vec   omega   = mkvec(radians(gyro->x), -radians(gyro->y), radians(gyro->z));
  const struct vec   moment =
      moments(self, rotation_error(q, desired), omega, &setpoint->attitudeRate);

  control->thrust = setpoint->mode.z == modeDisable ? setpoint->thrust : self->massThrust * force;
  if (control->thrust > 0.0f) {
    control->roll  = in_counts(moment.x);
    control->pitch = in_counts(moment.y);
    control->yaw   = in_counts(-moment.z);
    if (visnan(moment)) {
      // whole numbers cannot show it, the thrust can: the loop around stops the drone
      control->thrust = NAN;
    }
  } else {
    control->roll  = 0;
    control->pitch = 0;
    control->yaw   = 0;
    controllerMellingerReset(self);
  }

  self->z_axis_desired = mcolumn(desired, 2);
  self->cmd_thrust     = control->thrust;
  self->cmd_roll       = (float)control->roll;
  self->cmd_pitch      = (float)control->pitch;
  self->cmd_yaw        = (float)control->yaw;
  self->r_roll         = omega.x;
  self->r_pitch        = omega.y;
  self->r_yaw          = omega.z;
  self->accelz         = sensors->acc.z;
}

// -------------------------------------------------------------------------------------- variables

#define PARAMETER(name_, flags_) \
  CF_ROW("ctrlMel", #name_, FLOAT, flags_, controllerMellinger_t, name_)

static const cf_variable_t PARAMETERS[] = {
    PARAMETER(kp_xy, CF_CORE | CF_PERSISTENT),       PARAMETER(kd_xy, CF_CORE | CF_PERSISTENT),
    PARAMETER(ki_xy, CF_CORE | CF_PERSISTENT),       PARAMETER(i_range_xy, CF_PERSISTENT),
    PARAMETER(kp_z, CF_CORE | CF_PERSISTENT),        PARAMETER(kd_z, CF_CORE | CF_PERSISTENT),
    PARAMETER(ki_z, CF_CORE | CF_PERSISTENT),        PARAMETER(i_range_z, CF_PERSISTENT),
    PARAMETER(mass, CF_CORE | CF_PERSISTENT),        PARAMETER(massThrust, CF_CORE | CF_PERSISTENT),
    PARAMETER(kR_xy, CF_CORE | CF_PERSISTENT),       PARAMETER(kR_z, CF_CORE | CF_PERSISTENT),
    PARAMETER(kw_xy, CF_CORE | CF_PERSISTENT),       PARAMETER(kw_z, CF_CORE | CF_PERSISTENT),
    PARAMETER(ki_m_xy, CF_CORE | CF_PERSISTENT),     PARAMETER(ki_m_z, CF_CORE | CF_PERSISTENT),
    PARAMETER(kd_omega_rp, CF_CORE | CF_PERSISTENT), PARAMETER(i_range_m_xy, CF_PERSISTENT),
    PARAMETER(i_range_m_z, CF_PERSISTENT),
};

#define LOG(name_, member_) CF_ROW("ctrlMel", name_, FLOAT, 0, controllerMellinger_t, member_)

static const cf_variable_t LOGS[] = {
    LOG("cmd_thrust", cmd_thrust), LOG("cmd_roll", cmd_roll),    LOG("cmd_pitch", cmd_pitch),
    LOG("cmd_yaw", cmd_yaw),       LOG("r_roll", r_roll),        LOG("r_pitch", r_pitch),
    LOG("r_yaw", r_yaw),           LOG("accelz", accelz),        LOG("zdx", z_axis_desired.x),
    LOG("zdy", z_axis_desired.y),  LOG("zdz", z_axis_desired.z), LOG("i_err_x", i_error_x),
    LOG("i_err_y", i_error_y),     LOG("i_err_z", i_error_z),
};

cf_variables_t cf_controller_mellinger_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_controller_mellinger_logs(void) {
  return CF_TABLE(LOGS);
}
