#include "builtin/control/controller_brescianini.h"

#include <math.h>
#include <stddef.h>

#include "api/math3d.h"
#include "api/num.h"
#include "variable_row.h"

#define GRAVITY 9.81f                   // [m/s^2]
#define ARC_MINUTE (M_PI_F / 10800.0f)  // [rad]

#define TAU_RP_RATE 0.015f    // [s]
#define TAU_YAW_RATE 0.0075f  // [s]
#define COLL_MIN 1.0f         // [m/s^2]
#define COLL_MAX 18.0f        // [m/s^2]
#define OMEGA_RP_MAX 30.0f    // [rad/s]
#define OMEGA_YAW_MAX 10.0f   // [rad/s]
#define HEURISTIC_RP 12.0f    // [rad/s], a spin that is stopped with all might
#define HEURISTIC_YAW 5.0f    // [rad/s]

// [kg m^2]
static const struct mat33 INERTIA = {{
    {16.6e-6f, 0.83e-6f, 0.72e-6f},
    {0.83e-6f, 16.6e-6f, 1.8e-6f},
    {0.72e-6f, 1.8e-6f, 29.3e-6f},
}};

cf_status_t cf_controller_brescianini_boot(controllerBrescianini_t *self, cf_platform_t platform) {
  const cf_platform_facts_t *facts = cf_platform_facts(platform);
  if (facts == NULL) {
    return CF_ERR_UNKNOWN;
  }
  *self = (controllerBrescianini_t){
      .tau_xy        = 0.3f,
      .tau_z         = 0.3f,
      .zeta_xy       = 0.85f,
      .zeta_z        = 0.85f,
      .tau_rp        = 0.25f,
      .mixing_factor = 1.0f,
      .coll_fairness = 0.25f,
      .mass          = facts->mass,
  };
  return CF_OK;
}

void controllerBrescianiniInit(controllerBrescianini_t *self) {
  (void)self;
}

bool controllerBrescianiniTest(const controllerBrescianini_t *self) {
  (void)self;
  return true;
}

// ------------------------------------------------------------------------------------ quaternions

// The turn from one direction to another. Nearly parallel directions have no axis to speak of. Nor
// have parallel ones whose cosine rounds to less than 1, which upstream divides by zero; this
// difference changes no number that is one.
static struct quat turn_between(struct vec from, struct vec to) {
  const float      alpha  = acosf(constrain(vdot(from, to), -1.0f, 1.0f));
  const struct vec normal = vcross(from, to);
  const bool       none   = normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f;

  struct vec axis = mkvec(1.0f, 1.0f, 0.0f);
  if (fabsf(alpha) > ARC_MINUTE && !none) {
    axis = vnormalize(normal);
  }
  const float s = sinf(alpha / 2.0f);
  return (struct quat){.x = s * axis.x, .y = s * axis.y, .z = s * axis.z, .w = cosf(alpha / 2.0f)};
}

// --------------------------------------------------------------------------------------- position

// a third of a PID: spring, damper and feed-forward, [m/s^2]
static float wanted(float start, float tau, float zeta, float e_p, float e_v, float a) {
  float accel = start;
  accel += 1.0f / tau / tau * e_p;
  accel += 2.0f * zeta / tau * e_v;
  accel += a;
  return constrain(accel, -COLL_MAX, COLL_MAX);
}

static struct vec wanted_acceleration(const controllerBrescianini_t *self,
                                      const setpoint_t *setpoint, const state_t *state) {
  const point_t    *p = &state->position, *p_ref = &setpoint->position;
  const velocity_t *v = &state->velocity, *v_ref = &setpoint->velocity;
  const acc_t      *a = &setpoint->acceleration;
  return mkvec(wanted(0.0f, self->tau_xy, self->zeta_xy, p_ref->x - p->x, v_ref->x - v->x, a->x),
               wanted(0.0f, self->tau_xy, self->zeta_xy, p_ref->y - p->y, v_ref->y - v->y, a->y),
               wanted(GRAVITY, self->tau_z, self->zeta_z, p_ref->z - p->z, v_ref->z - v->z, a->z));
}

// Thrust along the body's axis that gives the vertical acceleration. None is none, also when the
// vehicle lies on its side: upstream has 0/0 there.
static float collective(float vertical, float r22) {
  return vertical == 0.0f ? 0.0f : vertical / r22;
}

// Shrinks an acceleration that asks for more than COLL_MAX. The share r of its x and y is the root
// of A r^2 + B r = C at which the norm is COLL_MAX; z gives way by the fairness f.
static struct vec reduced_acceleration(struct vec a, float fairness) {
  const float f = constrain(fairness, 0.0f, 1.0f);
  const float x = a.x;
  const float y = a.y;
  const float z = a.z - GRAVITY;

  const float rest = (1.0f - f) * z + GRAVITY;
  const float A    = x * x + y * y + z * f * (z * f);
  const float B    = 2.0f * z * f * rest;
  const float free = COLL_MAX * COLL_MAX - rest * rest;
  const float C    = free < 0.0f ? 0.0f : free;

  float r = 0.0f;
  if (!(fabsf(A) < 1e-6f)) {
    r = constrain((-B + sqrtf(B * B + 4.0f * A * C)) / (2.0f * A), 0.0f, 1.0f);
  }
  return mkvec(r * x, r * y, (r * f + (1.0f - f)) * z + GRAVITY);
}

// --------------------------------------------------------------------------------------- attitude

// between the error of the thrust direction and that of the whole attitude
static struct quat mixed_error(struct quat reduced, struct quat full, float mixing) {
  if (mixing <= 0.0f) {
    return reduced;
  }
  if (mixing >= 1.0f) {
    return full;
  }
  const struct quat d    = qnormalize(qqmul(qinv(reduced), full));
  const float       beta = 2.0f * acosf(constrain(d.w, -1.0f, 1.0f));
  const float       sign = d.z < 0.0f ? -1.0f : 1.0f;
  const struct quat yaw = {.z = sinf(beta * mixing / 2.0f) * sign, .w = cosf(beta * mixing / 2.0f)};
  return qnormalize(qqmul(reduced, yaw));
}

static struct quat attitude_error(const controllerBrescianini_t *self, struct quat q,
                                  struct vec z_now, struct vec z_wanted, float yaw_deg) {
  const struct quat reduced = qnormalize(qposreal(turn_between(z_now, z_wanted)));

  // always to the yaw angle of the setpoint, also when it asks for a rate
  const float       half = radians(yaw_deg) / 2.0f;
  const struct quat lean = turn_between(mkvec(0.0f, 0.0f, 1.0f), z_wanted);
  const struct quat goal = qqmul(lean, (struct quat){.z = sinf(half), .w = cosf(half)});
  const struct quat full = qnormalize(qposreal(qqmul(qinv(q), goal)));
  return mixed_error(reduced, full, self->mixing_factor);
}

// a fast spin in the wrong direction is stopped with the largest command in its own direction...
static float heuristic(float command, float omega, float limit, float largest) {
  if (command * omega < 0.0f && fabsf(omega) > limit) {
    return omega > 0.0f ? largest : -largest;
  }
  return command;
}

static void limit_rates(float omega[3], struct vec measured) {
  omega[0] = heuristic(omega[0], measured.x, HEURISTIC_RP, OMEGA_RP_MAX);
  omega[1] = heuristic(omega[1], measured.y, HEURISTIC_RP, OMEGA_RP_MAX);
  omega[2] = heuristic(omega[2], measured.z, HEURISTIC_YAW, OMEGA_YAW_MAX);

  // all three shrink alike
  float s = 1.0f;
  s       = fmaxf(s, fabsf(omega[0]) / OMEGA_RP_MAX);
  s       = fmaxf(s, fabsf(omega[1]) / OMEGA_RP_MAX);
  s       = fmaxf(s, fabsf(omega[2]) / OMEGA_YAW_MAX);
  for (int i = 0; i < 3; i++) {
    omega[i] /= s;
  }
}

static void outer_loop(controllerBrescianini_t *self, const setpoint_t *setpoint,
                       const state_t *state, struct vec measured) {
  const struct quat q   = {state->attitudeQuaternion.x, state->attitudeQuaternion.y,
                           state->attitudeQuaternion.z, state->attitudeQuaternion.w};
  const float       r02 = 2.0f * q.x * q.z + 2.0f * q.w * q.y;
  const float       r12 = 2.0f * q.y * q.z - 2.0f * q.w * q.x;
  const float       r22 = q.w * q.w - q.x * q.x - q.y * q.y + q.z * q.z;

  struct vec a = wanted_acceleration(self, setpoint, state);
  if (fabsf(collective(a.z, r22)) > COLL_MAX) {
    a = reduced_acceleration(a, self->coll_fairness);
  }
  self->control_thrust_accel = constrain(collective(a.z, r22), COLL_MIN, COLL_MAX);

  // free fall needs no direction; upstream divides by zero
  const bool        is_free  = a.x == 0.0f && a.y == 0.0f && a.z == 0.0f;
  const struct vec  z_now    = vnormalize(mkvec(r02, r12, r22));
  const struct vec  z_wanted = is_free ? z_now : vnormalize(a);
  const struct quat error    = attitude_error(self, q, z_now, z_wanted, setpoint->attitude.yaw);

  self->omega[0] = 2.0f / self->tau_rp * error.x;
  self->omega[1] = 2.0f / self->tau_rp * error.y;
  self->omega[2] = 2.0f / self->tau_rp * error.z + radians(setpoint->attitudeRate.yaw);
  limit_rates(self->omega, measured);
}

void controllerBrescianini(controllerBrescianini_t *self, control_t *control,
                           const setpoint_t *setpoint, const sensorData_t *sensors,
                           const state_t *state, const stabilizerStep_t stabilizerStep) {
  const Axis3f    *gyro  = &sensors->gyro;
  const struct vec omega = mkvec(radians(gyro->x), radians(gyro->y), radians(gyro->z));
  if (stabilizerStep % (RATE_MAIN_LOOP / RATE_100_HZ) == 0) {
    outer_loop(self, setpoint, state, omega);
  }

  control->controlMode = controlModeForceTorque;
  if (setpoint->mode.z == modeDisable) {
    control->thrustSi = 0.0f;
    control->torqueX  = 0.0f;
    control->torqueY  = 0.0f;
    control->torqueZ  = 0.0f;
    return;
  }

  const struct vec accel =
      mkvec((self->omega[0] - omega.x) / TAU_RP_RATE, (self->omega[1] - omega.y) / TAU_RP_RATE,
            (self->omega[2] - omega.z) / TAU_YAW_RATE);
  const struct vec torque = mvmul(INERTIA, accel);
  control->thrustSi       = self->control_thrust_accel * self->mass;
  control->torqueX        = torque.x;
  control->torqueY        = torque.y;
  control->torqueZ        = torque.z;
}

#define ROW(name_, member_) CF_ROW("ctrlAtt", name_, FLOAT, 0, controllerBrescianini_t, member_)

static const cf_variable_t PARAMETERS[] = {
    ROW("tau_xy", tau_xy),
    ROW("zeta_xy", zeta_xy),
    ROW("tau_z", tau_z),
    ROW("zeta_z", zeta_z),
    ROW("tau_rp", tau_rp),
    ROW("mixing_factor", mixing_factor),
    ROW("coll_fairness", coll_fairness),
};

cf_variables_t cf_controller_brescianini_parameters(void) {
  return CF_TABLE(PARAMETERS);
}
