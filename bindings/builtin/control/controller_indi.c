#include "builtin/control/controller_indi.h"

#include <math.h>
#include <stddef.h>

#include "api/math3d.h"
#include "api/num.h"
#include "builtin/control/cap_angle.h"
#include "builtin/control/controller_pid.h"
#include "convert.h"
#include "variable_row.h"

#define STEP_TIME 0.002f  // [s], 500 Hz

static const struct FloatRates ZERO_RATES = {0.0f, 0.0f, 0.0f};

void cf_controller_indi_boot(controllerINDI_t *self) {
  *self = (controllerINDI_t){
      .thrust_threshold    = 300.0f,
      .bound_control_input = 32000.0f,
      .outerLoopActive     = 1,
      .indi =
          {
              .g1                     = {0.0066146f, 0.0052125f, 0.001497f},
              .g2                     = 0.000043475f,
              .reference_acceleration = {5.0f, 5.0f, 5.0f, 24.0f, 24.0f, 24.0f},
              .act_dyn                = {0.03149f, 0.03149f, 0.03149f},
              .filt_cutoff            = 8.0f,
              .filt_cutoff_r          = 8.0f,
          },
  };
  cf_position_controller_indi_boot(&self->position);
}

void indi_init_filters(controllerINDI_t *self) {
  struct IndiVariables *indi  = &self->indi;
  const float           tau   = 1.0f / (2.0f * M_PI_F * indi->filt_cutoff);
  const float           tau_r = 1.0f / (2.0f * M_PI_F * indi->filt_cutoff_r);
  for (int i = 0; i < 3; i++) {
    const float own = i == 2 ? tau_r : tau;
    init_butterworth_2_low_pass(&indi->u[i], own, STEP_TIME, 0.0f);
    init_butterworth_2_low_pass(&indi->rate[i], own, STEP_TIME, 0.0f);
  }
}

// the inner loop starts from motors at rest
static void forget_commands(struct IndiVariables *indi) {
  indi->angular_accel_ref = ZERO_RATES;
  indi->u_act_dyn         = ZERO_RATES;
  indi->u_in              = ZERO_RATES;
}

void controllerINDIInit(controllerINDI_t *self, struct cf_controller_pid *pid) {
  forget_commands(&self->indi);
  indi_init_filters(self);
  cf_controller_pid_reinit(pid);
  positionControllerINDIInit(&self->position);
}

bool controllerINDITest(const controllerINDI_t *self) {
  (void)self;
  return true;
}

// ------------------------------------------------------------------------------------ the targets

// Without the outer loop the PID position controller gives degrees, and with a yaw rate the target
// is turned into radians once more at every step: both as upstream does it
// (docs/reference/control-geometric.md#14, items 8 and 9).
static void update_targets(controllerINDI_t *self, cf_controller_pid_t *pid,
                           const setpoint_t *setpoint, const sensorData_t *sensors,
                           const state_t *state, stabilizerStep_t step) {
  attitude_t *desired = &self->attitudeDesired;
  if (setpoint->mode.yaw == modeVelocity) {
    desired->yaw = radians(cf_cap_angle(desired->yaw + setpoint->attitudeRate.yaw * STEP_TIME));
  } else {
    desired->yaw = -radians(cf_cap_angle(setpoint->attitude.yaw));
  }

  const bool is_outer = self->outerLoopActive != 0;
  if (is_outer) {
    positionControllerINDI(&self->position, sensors, setpoint, state, &self->refOuterINDI);
    self->actuatorThrust = self->refOuterINDI.z;
    desired->roll        = self->refOuterINDI.x;
    desired->pitch       = self->refOuterINDI.y;
  } else if (step % (RATE_MAIN_LOOP / POSITION_RATE) == 0) {
    cf_position_controller_update(&pid->position, &self->actuatorThrust, desired, setpoint, state);
  }

  if (setpoint->mode.z == modeDisable) {
    self->actuatorThrust = setpoint->thrust;
  }
  if (setpoint->mode.x == modeDisable) {
    desired->roll = radians(setpoint->attitude.roll);
  }
  if (setpoint->mode.y == modeDisable) {
    desired->pitch = radians(setpoint->attitude.pitch);
  }
}

// attitude error to body rates; the error of yaw is not taken the short way round
static void update_rates(controllerINDI_t *self, cf_controller_pid_t *pid,
                         const setpoint_t *setpoint, const attitude_t *attitude) {
  const struct ReferenceSystem *gain    = &self->indi.reference_acceleration;
  const attitude_t             *desired = &self->attitudeDesired;

  self->rateDesired.roll  = gain->err_p * (desired->roll - radians(attitude->roll));
  self->rateDesired.pitch = gain->err_q * (desired->pitch - radians(attitude->pitch));
  self->rateDesired.yaw   = gain->err_r * (desired->yaw - -radians(attitude->yaw));

  if (setpoint->mode.roll == modeVelocity) {
    self->rateDesired.roll = radians(setpoint->attitudeRate.roll);
    cf_attitude_controller_reset_roll(&pid->attitude, attitude->roll);
  }
  if (setpoint->mode.pitch == modeVelocity) {
    self->rateDesired.pitch = radians(setpoint->attitudeRate.pitch);
    cf_attitude_controller_reset_pitch(&pid->attitude, attitude->pitch);
  }
}

// --------------------------------------------------------------------------------- the inner loop

static float derivative(const Butterworth2LowPass *filter) {
  return (filter->o[0] - filter->o[1]) * (float)ATTITUDE_RATE;
}

// body rates to motor commands: the commands that act now, plus what changes the acceleration
static void invert(controllerINDI_t *self, const Axis3f *gyro) {
  struct IndiVariables         *indi = &self->indi;
  const struct ReferenceSystem *gain = &indi->reference_acceleration;

  self->body_rates = (struct FloatRates){radians(gyro->x), -radians(gyro->y), -radians(gyro->z)};
  update_butterworth_2_low_pass(&indi->rate[0], self->body_rates.p);
  update_butterworth_2_low_pass(&indi->rate[1], self->body_rates.q);
  update_butterworth_2_low_pass(&indi->rate[2], self->body_rates.r);
  for (int i = 0; i < 3; i++) {
    indi->rate_d[i] = derivative(&indi->rate[i]);
  }

  update_butterworth_2_low_pass(&indi->u[0], indi->u_act_dyn.p);
  update_butterworth_2_low_pass(&indi->u[1], indi->u_act_dyn.q);
  update_butterworth_2_low_pass(&indi->u[2], indi->u_act_dyn.r);

  // the error takes the unfiltered rates
  indi->angular_accel_ref = (struct FloatRates){
      gain->rate_p * (self->rateDesired.roll - self->body_rates.p),
      gain->rate_q * (self->rateDesired.pitch - self->body_rates.q),
      gain->rate_r * (self->rateDesired.yaw - self->body_rates.r),
  };

  const struct FloatRates nu = indi->angular_accel_ref;
  indi->du                   = (struct FloatRates){
      (1.0f / indi->g1.p) * (nu.p - indi->rate_d[0]),
      (1.0f / indi->g1.q) * (nu.q - indi->rate_d[1]),
      (1.0f / (indi->g1.r + indi->g2)) * (nu.r - indi->rate_d[2] + indi->g2 * indi->du.r),
  };

  const float bound = self->bound_control_input;
  indi->u_in        = (struct FloatRates){
      constrain(indi->u[0].o[0] + indi->du.p, -bound, bound),
      constrain(indi->u[1].o[0] + indi->du.q, -bound, bound),
      constrain(indi->u[2].o[0] + indi->du.r, -bound, bound),
  };

  indi->u_act_dyn.p += indi->act_dyn.p * (indi->u_in.p - indi->u_act_dyn.p);
  indi->u_act_dyn.q += indi->act_dyn.q * (indi->u_in.q - indi->u_act_dyn.q);
  indi->u_act_dyn.r += indi->act_dyn.r * (indi->u_in.r - indi->u_act_dyn.r);
}

// thrust is 0: resets the PID loops to the current state, where the next flight starts
static void rest(controllerINDI_t *self, cf_controller_pid_t *pid, const state_t *state) {
  const point_t *at = &state->position;
  cf_attitude_controller_reset(&pid->attitude, &state->attitude);
  cf_position_controller_reset(&pid->position, at->x, at->y, at->z);
  self->attitudeDesired.yaw = -state->attitude.yaw;
}

void controllerINDI(controllerINDI_t *self, struct cf_controller_pid *pid, control_t *control,
                    const setpoint_t *setpoint, const sensorData_t *sensors, const state_t *state,
                    const stabilizerStep_t stabilizerStep) {
  control->controlMode = controlModeLegacy;

  if (stabilizerStep % (RATE_MAIN_LOOP / ATTITUDE_RATE) == 0) {
    update_targets(self, pid, setpoint, sensors, state, stabilizerStep);
    update_rates(self, pid, setpoint, &state->attitude);
    invert(self, &sensors->gyro);
  }

  self->indi.thrust = self->actuatorThrust;
  if (self->indi.thrust < self->thrust_threshold) {
    forget_commands(&self->indi);
    if (self->indi.thrust == 0.0f) {
      rest(self, pid, state);
    }
  }

  // whole numbers cannot show what is no number, the thrust can: the loop around stops the drone
  const struct FloatRates u         = self->indi.u_in;
  const bool              is_number = !(isnan(u.p) || isnan(u.q) || isnan(u.r));

  control->thrust = is_number ? self->indi.thrust : NAN;
  control->roll   = cf_to_int16(u.p);
  control->pitch  = cf_to_int16(u.q);
  control->yaw    = cf_to_int16(u.r);
}

#define ROW(name_, member_) CF_ROW("ctrlINDI", name_, FLOAT, 0, controllerINDI_t, member_)

#define ROWS_PQR(name_, member_) \
  ROW(name_ "_p", member_.p), ROW(name_ "_q", member_.q), ROW(name_ "_r", member_.r)

static const cf_variable_t PARAMETERS[] = {
    ROW("thrust_threshold", thrust_threshold),
    ROW("bound_ctrl_input", bound_control_input),
    ROWS_PQR("g1", indi.g1),
    ROW("g2", indi.g2),
    ROW("ref_err_p", indi.reference_acceleration.err_p),
    ROW("ref_err_q", indi.reference_acceleration.err_q),
    ROW("ref_err_r", indi.reference_acceleration.err_r),
    ROW("ref_rate_p", indi.reference_acceleration.rate_p),
    ROW("ref_rate_q", indi.reference_acceleration.rate_q),
    ROW("ref_rate_r", indi.reference_acceleration.rate_r),
    ROWS_PQR("act_dyn", indi.act_dyn),
    ROW("filt_cutoff", indi.filt_cutoff),
    ROW("filt_cutoff_r", indi.filt_cutoff_r),
    CF_ROW("ctrlINDI", "outerLoopActive", UINT8, 0, controllerINDI_t, outerLoopActive),
};

cf_variables_t cf_controller_indi_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

// all three of r_roll, r_pitch, r_yaw show the rate about x, as upstream does
static const cf_variable_t LOGS[] = {
    ROW("cmd_thrust", indi.thrust),
    ROW("cmd_roll", indi.u_in.p),
    ROW("cmd_pitch", indi.u_in.q),
    ROW("cmd_yaw", indi.u_in.r),
    ROW("r_roll", body_rates.p),
    ROW("r_pitch", body_rates.p),
    ROW("r_yaw", body_rates.p),
    ROWS_PQR("u_act_dyn", indi.u_act_dyn),
    ROWS_PQR("du", indi.du),
    ROWS_PQR("ang_accel_ref", indi.angular_accel_ref),
    ROW("rate_d[0]", indi.rate_d[0]),
    ROW("rate_d[1]", indi.rate_d[1]),
    ROW("rate_d[2]", indi.rate_d[2]),
    ROW("uf_p", indi.u[0].o[0]),
    ROW("uf_q", indi.u[1].o[0]),
    ROW("uf_r", indi.u[2].o[0]),
    ROW("Omega_f_p", indi.rate[0].o[0]),
    ROW("Omega_f_q", indi.rate[1].o[0]),
    ROW("Omega_f_r", indi.rate[2].o[0]),
    ROW("n_p", attitudeDesired.roll),
    ROW("n_q", attitudeDesired.pitch),
    ROW("n_r", attitudeDesired.yaw),
};

cf_variables_t cf_controller_indi_logs(void) {
  return CF_TABLE(LOGS);
}
