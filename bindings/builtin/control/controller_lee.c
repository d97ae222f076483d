#include "builtin/control/controller_lee.h"

#include <math.h>
#include <stddef.h>

#include "variable_row.h"

#define GRAVITY 9.81f              // [m/s^2]
#define DT (1.0f / ATTITUDE_RATE)  // [s]
#define FULL_COUNT 65535.0f        // [counts]
#define MIN_COUNTS 1000.0f         // [counts], a pilot's thrust below which the motors stop
#define MIN_THRUST 0.01f           // [N], below which the integrals start over
#define NO_THRUST 1e-9f            // [N], too little to divide by

cf_status_t cf_controller_lee_init(controllerLee_t *lee, cf_platform_t platform) {
  const cf_platform_facts_t *facts = cf_platform_facts(platform);
  if (facts == NULL) {
    return CF_ERR_UNKNOWN;
  }
  *lee = (controllerLee_t){
      .mass         = facts->mass,
      .J            = {16.571710e-6f, 16.655602e-6f, 29.261652e-6f},
      .Kpos_P       = {7.0f, 7.0f, 7.0f},
      .Kpos_P_limit = 100.0f,
      .Kpos_D       = {4.0f, 4.0f, 4.0f},
      .Kpos_D_limit = 100.0f,
      .Kpos_I       = {0.0f, 0.0f, 0.0f},
      .Kpos_I_limit = 2.0f,
      .KR           = {0.007f, 0.007f, 0.008f},
      .Komega       = {0.00115f, 0.00115f, 0.002f},
      .KI           = {0.03f, 0.03f, 0.03f},
      .max_thrust   = 4.0f * facts->thrust.thrust_max,
  };
  return CF_OK;
}

void controllerLeeInit(controllerLee_t *self) {
  cf_controller_lee_init(self, CF_PLATFORM_CF2);
}

void controllerLeeReset(controllerLee_t *self) {
  self->i_error_pos = vzero();
  self->i_error_att = vzero();
}

// ----------------------------------------------------------------------------- thrust and attitude

static struct vec clamped(struct vec v, float limit) {
  return mkvec(clamp(v.x, -limit, limit), clamp(v.y, -limit, limit), clamp(v.z, -limit, limit));
}

// [rad]
static float desired_yaw(controllerLee_t *self, const setpoint_t *setpoint, const state_t *state) {
  if (setpoint->mode.yaw == modeVelocity) {
    // relative to the present yaw: a turn is not integrated
    return radians(state->attitude.yaw + setpoint->attitudeRate.yaw * DT);
  }
  if (setpoint->mode.yaw == modeAbs) {
    return radians(setpoint->attitude.yaw);
  }
  if (setpoint->mode.quat == modeAbs) {
    const quaternion_t *q = &setpoint->attitudeQuaternion;
    self->rpy_des         = quat2rpy(mkquat(q->x, q->y, q->z, q->w));
    return self->rpy_des.z;
  }
  return 0.0f;
}

// Axes as columns: z along the force, x as near to the heading [rad] as that allows.
static struct mat33 axes_of(struct vec force, bool is_pulling, float yaw) {
  const struct vec z     = is_pulling ? vnormalize(force) : vbasis(2);
  const struct vec cross = vcross(z, mkvec(cosf(yaw), sinf(yaw), 0.0f));
  const struct vec y     = vmag(cross) > 0.0f ? vnormalize(cross) : vbasis(1);
  return mcolumns(vcross(y, z), y, z);
}

// F = a + g + Kd e_v + Kp e_p + Ki i [m/s^2], of which the thrust [N] is the part along the present
// z axis. Returns the thrust and writes the desired attitude.
static float follow_position(controllerLee_t *self, const setpoint_t *setpoint,
                             const state_t *state, struct mat33 R, float yaw) {
  const point_t    *p   = &state->position;
  const velocity_t *v   = &state->velocity;
  const point_t    *p_d = &setpoint->position;
  const velocity_t *v_d = &setpoint->velocity;
  const acc_t      *a_d = &setpoint->acceleration;

  self->p_error =
      clamped(vsub(mkvec(p_d->x, p_d->y, p_d->z), mkvec(p->x, p->y, p->z)), self->Kpos_P_limit);
  self->v_error =
      clamped(vsub(mkvec(v_d->x, v_d->y, v_d->z), mkvec(v->x, v->y, v->z)), self->Kpos_D_limit);
  self->i_error_pos = vadd(self->i_error_pos, vscl(DT, self->p_error));

  const struct vec F =
      vadd4(mkvec(a_d->x, a_d->y, a_d->z + GRAVITY), veltmul(self->Kpos_D, self->v_error),
            veltmul(self->Kpos_P, self->p_error), veltmul(self->Kpos_I, self->i_error_pos));
  self->thrustSi = self->mass * vdot(F, mvmul(R, vbasis(2)));
  if (self->thrustSi < MIN_THRUST) {
    controllerLeeReset(self);
  }
  self->R_des = axes_of(F, self->thrustSi > 0.0f, yaw);
  return self->thrustSi;
}

// The attitude of a pilot; legacy pitch, where positive lifts the nose.
static struct mat33 axes_of_angles(const attitude_t *attitude, float yaw) {
  const struct vec rpy = mkvec(radians(attitude->roll), -radians(attitude->pitch), yaw);
  return quat2rotmat(rpy2quat(rpy));
}

static void stop(controllerLee_t *self, control_t *control) {
  control->controlMode = controlModeForceTorque;
  control->thrustSi    = 0.0f;
  vstoref(vzero(), control->torque);
  controllerLeeReset(self);
}

// ----------------------------------------------------------------------------------------- torque

// 1/2 (E(2,1), E(0,2), E(1,0)) with E = Rd' R - R' Rd
static struct vec rotation_error(struct mat33 R, struct mat33 R_des) {
  const struct mat33 E = msub(mmul(mtranspose(R_des), R), mmul(mtranspose(R), R_des));
  return vscl(0.5f, mkvec(E.m[2][1], E.m[0][2], E.m[1][0]));
}

// Rates [rad/s] that turn the desired z axis as the jerk asks, in desired axes.
static struct vec desired_rates(const controllerLee_t *self, const setpoint_t *setpoint,
                                float thrust) {
  const jerk_t    *jerk = &setpoint->jerk;
  const struct vec x    = mcolumn(self->R_des, 0);
  const struct vec y    = mcolumn(self->R_des, 1);
  const struct vec z    = mcolumn(self->R_des, 2);

  // upstream spares only a thrust of exactly zero; next to it its rates are infinite
  struct vec h_w = vzero();
  if (fabsf(thrust) > NO_THRUST) {
    h_w = vscl(self->mass / thrust, vorthunit(mkvec(jerk->x, jerk->y, jerk->z), z));
  }
  return mkvec(-vdot(h_w, y), vdot(h_w, x),
               radians(setpoint->attitudeRate.yaw) * vdot(z, vbasis(2)));
}

// -KR e_R - Komega e_w - KI i + w x J w [N m]
static struct vec torque(controllerLee_t *self, const setpoint_t *setpoint, struct mat33 R,
                         float thrust) {
  const struct vec omega_des = desired_rates(self, setpoint, thrust);
  self->omega_r              = mvmul(mmul(mtranspose(R), self->R_des), omega_des);

  const struct vec omega_error = vsub(self->omega, self->omega_r);
  const struct vec r_error     = rotation_error(R, self->R_des);
  self->i_error_att            = vadd(self->i_error_att, vscl(DT, r_error));

  return vadd4(vneg(veltmul(self->KR, r_error)), vneg(veltmul(self->Komega, omega_error)),
               vneg(veltmul(self->KI, self->i_error_att)),
               vcross(self->omega, veltmul(self->J, self->omega)));
}

void controllerLee(controllerLee_t *self, control_t *control, const setpoint_t *setpoint,
                   const sensorData_t *sensors, const state_t *state,
                   const stabilizerStep_t stabilizerStep) {
  if (stabilizerStep % (RATE_MAIN_LOOP / ATTITUDE_RATE) != 0) {
    return;
  }

  const setpoint_mode_t *mode     = &setpoint->mode;
  const quaternion_t    *attitude = &state->attitudeQuaternion;
  const struct quat      q        = mkquat(attitude->x, attitude->y, attitude->z, attitude->w);
  const struct mat33     R        = quat2rotmat(q);
  const float            yaw      = desired_yaw(self, setpoint, state);

  // velocities alone are not followed
  if (mode->x == modeAbs || mode->y == modeAbs || mode->z == modeAbs) {
    control->thrustSi = follow_position(self, setpoint, state, R, yaw);
  } else {
    if (mode->z == modeDisable && setpoint->thrust < MIN_COUNTS) {
      stop(self, control);
      return;
    }
    control->thrustSi = setpoint->thrust / FULL_COUNT * self->max_thrust;
    self->R_des       = axes_of_angles(&setpoint->attitude, yaw);
  }

  self->rpy     = quat2rpy(q);
  self->rpy_des = quat2rpy(mat2quat(self->R_des));
  self->omega = mkvec(radians(sensors->gyro.x), radians(sensors->gyro.y), radians(sensors->gyro.z));
  self->u     = torque(self, setpoint, R, control->thrustSi);
  control->controlMode = controlModeForceTorque;
  vstoref(self->u, control->torque);
}

// -------------------------------------------------------------------------------------- variables

#define ROW(name_, member_) CF_ROW("ctrlLee", name_, FLOAT, 0, controllerLee_t, member_)

static const cf_variable_t PARAMETERS[] = {
    ROW("KR_x", KR.x),        ROW("KR_y", KR.y),
    ROW("KR_z", KR.z),        ROW("KI_x", KI.x),
    ROW("KI_y", KI.y),        ROW("KI_z", KI.z),
    ROW("Kw_x", Komega.x),    ROW("Kw_y", Komega.y),
    ROW("Kw_z", Komega.z),    ROW("J_x", J.x),
    ROW("J_y", J.y),          ROW("J_z", J.z),
    ROW("Kpos_Px", Kpos_P.x), ROW("Kpos_Py", Kpos_P.y),
    ROW("Kpos_Pz", Kpos_P.z), ROW("Kpos_P_limit", Kpos_P_limit),
    ROW("Kpos_Dx", Kpos_D.x), ROW("Kpos_Dy", Kpos_D.y),
    ROW("Kpos_Dz", Kpos_D.z), ROW("Kpos_D_limit", Kpos_D_limit),
    ROW("Kpos_Ix", Kpos_I.x), ROW("Kpos_Iy", Kpos_I.y),
    ROW("Kpos_Iz", Kpos_I.z), ROW("Kpos_I_limit", Kpos_I_limit),
    ROW("mass", mass),
};

static const cf_variable_t LOGS[] = {
    ROW("KR_x", KR.x),
    ROW("KR_y", KR.y),
    ROW("KR_z", KR.z),
    ROW("Kw_x", Komega.x),
    ROW("Kw_y", Komega.y),
    ROW("Kw_z", Komega.z),
    ROW("Kpos_Px", Kpos_P.x),
    ROW("Kpos_Py", Kpos_P.y),
    ROW("Kpos_Pz", Kpos_P.z),
    ROW("Kpos_Dx", Kpos_D.x),
    ROW("Kpos_Dy", Kpos_D.y),
    ROW("Kpos_Dz", Kpos_D.z),
    ROW("thrustSi", thrustSi),
    ROW("torquex", u.x),
    ROW("torquey", u.y),
    ROW("torquez", u.z),
    ROW("rpyx", rpy.x),
    ROW("rpyy", rpy.y),
    ROW("rpyz", rpy.z),
    ROW("rpydx", rpy_des.x),
    ROW("rpydy", rpy_des.y),
    ROW("rpydz", rpy_des.z),
    ROW("error_posx", p_error.x),
    ROW("error_posy", p_error.y),
    ROW("error_posz", p_error.z),
    ROW("error_velx", v_error.x),
    ROW("error_vely", v_error.y),
    ROW("error_velz", v_error.z),
    ROW("omegax", omega.x),
    ROW("omegay", omega.y),
    ROW("omegaz", omega.z),
    ROW("omegarx", omega_r.x),
    ROW("omegary", omega_r.y),
    ROW("omegarz", omega_r.z),
};

cf_variables_t cf_controller_lee_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_controller_lee_logs(void) {
  return CF_TABLE(LOGS);
}
