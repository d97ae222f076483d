#include "builtin/control/position_controller_indi.h"

#include "api/math3d.h"
#include "api/num.h"
#include "variable_row.h"

#define STEP_TIME 0.002f              // [s], 500 Hz
#define GRAVITY 9.81f                 // [m/s^2]
#define LARGEST_THRUST 60000.0f       // [counts]
#define THRUST_PER_COUNT 0.00024730f  // [m/s^2 per count], K_thr

void cf_position_controller_indi_boot(positionControllerINDI_t *self) {
  *self = (positionControllerINDI_t){
      .K_xi_x      = 1.0f,
      .K_xi_y      = 1.0f,
      .K_xi_z      = 1.0f,
      .K_dxi_x     = 5.0f,
      .K_dxi_y     = 5.0f,
      .K_dxi_z     = 5.0f,
      .pq_clamping = 10.0f,
      .indiOuter   = {.filt_cutoff = 8.0f, .act_dyn_posINDI = 0.03149f},
  };
}

void positionControllerINDIInit(positionControllerINDI_t *self) {
  struct IndiOuterVariables *outer = &self->indiOuter;
  const float                tau   = 1.0f / (2.0f * M_PI_F * outer->filt_cutoff);
  for (int i = 0; i < 3; i++) {
    init_butterworth_2_low_pass(&outer->ddxi[i], tau, STEP_TIME, 0.0f);
    init_butterworth_2_low_pass(&outer->ang[i], tau, STEP_TIME, 0.0f);
  }
  init_butterworth_2_low_pass(&outer->thr, tau, STEP_TIME, 0.0f);
}

// ---------------------------------------------------------------------------- the wanted and felt

// v_ref = K_xi (p_ref - p) on axes in absolute mode, the setpoint's on others
static void refer_velocity(positionControllerINDI_t *self, const setpoint_t *setpoint,
                           const state_t *state) {
  const point_t    *p    = &state->position;
  const point_t    *goal = &setpoint->position;
  const velocity_t *v    = &setpoint->velocity;

  self->velocityRef = (struct Vectr){v->x, -v->y, -v->z};
  if (setpoint->mode.x == modeAbs) {
    self->positionRef.x = goal->x;
    self->velocityRef.x = self->K_xi_x * (self->positionRef.x - p->x);
  }
  if (setpoint->mode.y == modeAbs) {
    self->positionRef.y = -goal->y;
    self->velocityRef.y = self->K_xi_y * (self->positionRef.y - -p->y);
  }
  if (setpoint->mode.z == modeAbs) {
    self->positionRef.z = -goal->z;
    self->velocityRef.z = self->K_xi_z * (self->positionRef.z - -p->z);
  }
}

// a_ref = K_dxi (v_ref - v)
static void refer_acceleration(positionControllerINDI_t *self, const velocity_t *v) {
  self->velS                       = (struct Vectr){v->x, -v->y, -v->z};
  self->indiOuter.linear_accel_ref = (struct Vectr){
      self->K_dxi_x * (self->velocityRef.x - self->velS.x),
      self->K_dxi_y * (self->velocityRef.y - self->velS.y),
      self->K_dxi_z * (self->velocityRef.z - self->velS.z),
  };
}

static void filter_sensors(struct IndiOuterVariables *outer, const Axis3f *acc,
                           const attitude_t *attitude) {
  outer->linear_accel_s = (struct Vectr){acc->x * GRAVITY, -acc->y * GRAVITY, -acc->z * GRAVITY};
  outer->linear_accel_f = (struct Vectr){
      update_butterworth_2_low_pass(&outer->ddxi[0], outer->linear_accel_s.x),
      update_butterworth_2_low_pass(&outer->ddxi[1], outer->linear_accel_s.y),
      update_butterworth_2_low_pass(&outer->ddxi[2], outer->linear_accel_s.z),
  };

  outer->attitude_s =
      (struct Angles){radians(attitude->roll), radians(attitude->pitch), -radians(attitude->yaw)};
  outer->attitude_f = (struct Angles){
      update_butterworth_2_low_pass(&outer->ang[0], outer->attitude_s.phi),
      update_butterworth_2_low_pass(&outer->ang[1], outer->attitude_s.theta),
      update_butterworth_2_low_pass(&outer->ang[2], outer->attitude_s.psi),
  };
}

// ------------------------------------------------------------------------------- what motors could

typedef struct {
  float s_phi;
  float c_phi;
  float s_theta;
  float c_theta;
  float s_psi;
  float c_psi;
} turn_t;

static turn_t turn(const struct Angles *a) {
  return (turn_t){.s_phi   = sinf(a->phi),
                  .c_phi   = cosf(a->phi),
                  .s_theta = sinf(a->theta),
                  .c_theta = cosf(a->theta),
                  .s_psi   = sinf(a->psi),
                  .c_psi   = cosf(a->psi)};
}

// M = Rz(psi) Ry(theta) Rx(phi)
static struct mat33 body_to_world(turn_t t) {
  return (struct mat33){{
      {t.c_theta * t.c_psi, t.s_phi * t.s_theta * t.c_psi - t.c_phi * t.s_psi,
       t.c_phi * t.s_theta * t.c_psi + t.s_phi * t.s_psi},
      {t.c_theta * t.s_psi, t.s_phi * t.s_theta * t.s_psi + t.c_phi * t.c_psi,
       t.c_phi * t.s_theta * t.s_psi - t.s_phi * t.c_psi},
      {-t.s_theta, t.s_phi * t.c_theta, t.c_phi * t.c_theta},
  }};
}

// G: change of the acceleration by roll, pitch and specific thrust, near a thrust of one g
static struct mat33 effectiveness(turn_t t) {
  const float g = -GRAVITY;
  return (struct mat33){{
      {(t.c_phi * t.s_psi - t.s_phi * t.s_theta * t.c_psi) * g, (t.c_phi * t.c_theta * t.c_psi) * g,
       t.s_phi * t.s_psi + t.c_phi * t.s_theta * t.c_psi},
      {(-t.c_phi * t.c_psi - t.s_phi * t.s_theta * t.s_psi) * g,
       (t.c_phi * t.c_theta * t.s_psi) * g, -t.s_phi * t.c_psi + t.c_phi * t.s_theta * t.s_psi},
      {(-t.s_phi * t.c_theta) * g, (-t.c_phi * t.s_theta) * g, t.c_phi * t.c_theta},
  }};
}

// A^-1 by cofactors; not finite when A is singular
static struct mat33 inverse(const struct mat33 *a) {
  const float a11 = a->m[0][0], a12 = a->m[0][1], a13 = a->m[0][2];
  const float a21 = a->m[1][0], a22 = a->m[1][1], a23 = a->m[1][2];
  const float a31 = a->m[2][0], a32 = a->m[2][1], a33 = a->m[2][2];
  const float det = (a11 * a22 * a33 + a12 * a23 * a31 + a21 * a32 * a13) -
                    (a13 * a22 * a31 + a11 * a32 * a23 + a12 * a21 * a33);
  return (struct mat33){{
      {(a22 * a33 - a23 * a32) / det, (a13 * a32 - a12 * a33) / det, (a12 * a23 - a13 * a22) / det},
      {(a23 * a31 - a21 * a33) / det, (a11 * a33 - a13 * a31) / det, (a13 * a21 - a11 * a23) / det},
      {(a21 * a32 - a22 * a31) / det, (a12 * a31 - a11 * a32) / det, (a11 * a22 - a12 * a21) / det},
  }};
}

// P e with the pseudo-inverse P = (G'G)^-1 G'
static struct vec solve(const struct mat33 *g, struct vec e) {
  struct mat33 a = {0};
  struct mat33 p = {0};
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      a.m[i][j] = g->m[0][i] * g->m[0][j] + g->m[1][i] * g->m[1][j] + g->m[2][i] * g->m[2][j];
    }
  }
  const struct mat33 b = inverse(&a);
  for (int i = 0; i < 3; i++) {
    for (int j = 0; j < 3; j++) {
      p.m[i][j] = b.m[i][0] * g->m[j][0] + b.m[i][1] * g->m[j][1] + b.m[i][2] * g->m[j][2];
    }
  }
  return mvmul(p, e);
}

void positionControllerINDI(positionControllerINDI_t *self, const sensorData_t *sensors,
                            const setpoint_t *setpoint, const state_t *state,
                            vector_t *refOuterINDI) {
  struct IndiOuterVariables *outer = &self->indiOuter;
  refer_velocity(self, setpoint, state);
  refer_acceleration(self, &state->velocity);
  filter_sensors(outer, &sensors->acc, &state->attitude);

  // e = a_ref - (M a_f + gravity)
  const turn_t       t    = turn(&outer->attitude_f);
  const struct mat33 m    = body_to_world(t);
  const struct Vectr a_f  = outer->linear_accel_f;
  const struct vec   felt = mvmul(m, mkvec(a_f.x, a_f.y, a_f.z));
  outer->linear_accel_ft  = (struct Vectr){felt.x, felt.y, felt.z + GRAVITY};
  outer->linear_accel_err = (struct Vectr){
      outer->linear_accel_ref.x - outer->linear_accel_ft.x,
      outer->linear_accel_ref.y - outer->linear_accel_ft.y,
      outer->linear_accel_ref.z - outer->linear_accel_ft.z,
  };

  // increments that make up for it
  const struct mat33 g = effectiveness(t);
  const struct Vectr e = outer->linear_accel_err;
  const struct vec   i = solve(&g, mkvec(e.x, e.y, e.z));
  outer->phi_tilde     = i.x;
  outer->theta_tilde   = i.y;
  outer->T_tilde       = -i.z / THRUST_PER_COUNT;

  // on top of what is there: the lean as measured, the thrust as a model of the motors has it
  outer->T_inner_f = update_butterworth_2_low_pass(&outer->thr, outer->T_incremented);
  outer->T_inner   = outer->T_inner + outer->act_dyn_posINDI * (outer->T_inner_f - outer->T_inner);

  const float limit       = radians(self->pq_clamping);
  outer->T_incremented    = constrain(outer->T_tilde + outer->T_inner, 0.0f, LARGEST_THRUST);
  outer->attitude_c.phi   = constrain(outer->attitude_f.phi + outer->phi_tilde, -limit, limit);
  outer->attitude_c.theta = constrain(outer->attitude_f.theta + outer->theta_tilde, -limit, limit);

  refOuterINDI->x = outer->attitude_c.phi;
  refOuterINDI->y = outer->attitude_c.theta;
  refOuterINDI->z = outer->T_incremented;
}

#define ROW(name_, member_) \
  CF_ROW("posCtrlIndi", name_, FLOAT, 0, positionControllerINDI_t, member_)

#define ROWS_XYZ(name_, member_) \
  ROW(name_ "_x", member_.x), ROW(name_ "_y", member_.y), ROW(name_ "_z", member_.z)

#define ROWS_RPY(name_, member_)                                       \
  ROW(name_ "_roll", member_.phi), ROW(name_ "_pitch", member_.theta), \
      ROW(name_ "_yaw", member_.psi)

static const cf_variable_t PARAMETERS[] = {
    ROW("K_xi_x", K_xi_x),           ROW("K_xi_y", K_xi_y),   ROW("K_xi_z", K_xi_z),
    ROW("K_dxi_x", K_dxi_x),         ROW("K_dxi_y", K_dxi_y), ROW("K_dxi_z", K_dxi_z),
    ROW("pq_clamping", pq_clamping),
};

cf_variables_t cf_position_controller_indi_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

static const cf_variable_t LOGS[] = {
    ROWS_XYZ("posRef", positionRef),
    ROWS_XYZ("velS", velS),
    ROWS_XYZ("velRef", velocityRef),
    ROWS_RPY("angS", indiOuter.attitude_s),
    ROWS_RPY("angF", indiOuter.attitude_f),
    ROWS_XYZ("accRef", indiOuter.linear_accel_ref),
    ROWS_XYZ("accS", indiOuter.linear_accel_s),
    ROWS_XYZ("accF", indiOuter.linear_accel_f),
    ROWS_XYZ("accFT", indiOuter.linear_accel_ft),
    ROWS_XYZ("accErr", indiOuter.linear_accel_err),
    ROW("phi_tilde", indiOuter.phi_tilde),
    ROW("theta_tilde", indiOuter.theta_tilde),
    ROW("T_tilde", indiOuter.T_tilde),
    ROW("T_inner", indiOuter.T_inner),
    ROW("T_inner_f", indiOuter.T_inner_f),
    ROW("T_incremented", indiOuter.T_incremented),
    ROW("cmd_phi", indiOuter.attitude_c.phi),
    ROW("cmd_theta", indiOuter.attitude_c.theta),
};

cf_variables_t cf_position_controller_indi_logs(void) {
  return CF_TABLE(LOGS);
}
