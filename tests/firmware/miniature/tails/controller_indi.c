// PRECISE_LANDING INDI
// what others may look at
struct FloatRates body_rates = {0, 0, 0};

void indi_init_filters(void);

void indi_init_filters(void) {
  init_filters(&self);
}

void controllerINDIInit(void) {
  forget_commands(&self.indi);
  indi_init_filters();
  attitudeControllerInit(STEP_TIME);
  positionControllerInit();
  positionControllerINDIInit();
}

bool controllerINDITest(void) {
  return attitudeControllerTest();
}

void controllerINDI(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                    const state_t *state, const stabilizerStep_t stabilizerStep) {
  update(&self, control, setpoint, sensors, state, stabilizerStep);
  body_rates = self.body_rates;
}

PARAM_GROUP_START(ctrlINDI)
PARAM_ADD(PARAM_FLOAT, thrust_threshold, &self.thrust_threshold)
PARAM_ADD(PARAM_FLOAT, bound_ctrl_input, &self.bound_control_input)
PARAM_ADD(PARAM_FLOAT, g1_p, &self.indi.g1.p)
PARAM_ADD(PARAM_FLOAT, g1_q, &self.indi.g1.q)
PARAM_ADD(PARAM_FLOAT, g1_r, &self.indi.g1.r)
PARAM_ADD(PARAM_FLOAT, g2, &self.indi.g2)
PARAM_ADD(PARAM_FLOAT, ref_err_p, &self.indi.reference_acceleration.err_p)
PARAM_ADD(PARAM_FLOAT, ref_err_q, &self.indi.reference_acceleration.err_q)
PARAM_ADD(PARAM_FLOAT, ref_err_r, &self.indi.reference_acceleration.err_r)
PARAM_ADD(PARAM_FLOAT, ref_rate_p, &self.indi.reference_acceleration.rate_p)
PARAM_ADD(PARAM_FLOAT, ref_rate_q, &self.indi.reference_acceleration.rate_q)
PARAM_ADD(PARAM_FLOAT, ref_rate_r, &self.indi.reference_acceleration.rate_r)
PARAM_ADD(PARAM_FLOAT, act_dyn_p, &self.indi.act_dyn.p)
PARAM_ADD(PARAM_FLOAT, act_dyn_q, &self.indi.act_dyn.q)
PARAM_ADD(PARAM_FLOAT, act_dyn_r, &self.indi.act_dyn.r)
PARAM_ADD(PARAM_FLOAT, filt_cutoff, &self.indi.filt_cutoff)
PARAM_ADD(PARAM_FLOAT, filt_cutoff_r, &self.indi.filt_cutoff_r)
PARAM_ADD(PARAM_UINT8, outerLoopActive, &self.outerLoopActive)
PARAM_GROUP_STOP(ctrlINDI)

LOG_GROUP_START(ctrlINDI)
LOG_ADD(LOG_FLOAT, cmd_thrust, &self.indi.thrust)
LOG_ADD(LOG_FLOAT, cmd_roll, &self.indi.u_in.p)
LOG_ADD(LOG_FLOAT, cmd_pitch, &self.indi.u_in.q)
LOG_ADD(LOG_FLOAT, cmd_yaw, &self.indi.u_in.r)
LOG_ADD(LOG_FLOAT, r_roll, &body_rates.p)
LOG_ADD(LOG_FLOAT, r_pitch, &body_rates.p)
LOG_ADD(LOG_FLOAT, r_yaw, &body_rates.p)
LOG_ADD(LOG_FLOAT, u_act_dyn_p, &self.indi.u_act_dyn.p)
LOG_ADD(LOG_FLOAT, u_act_dyn_q, &self.indi.u_act_dyn.q)
LOG_ADD(LOG_FLOAT, u_act_dyn_r, &self.indi.u_act_dyn.r)
LOG_ADD(LOG_FLOAT, du_p, &self.indi.du.p)
LOG_ADD(LOG_FLOAT, du_q, &self.indi.du.q)
LOG_ADD(LOG_FLOAT, du_r, &self.indi.du.r)
LOG_ADD(LOG_FLOAT, ang_accel_ref_p, &self.indi.angular_accel_ref.p)
LOG_ADD(LOG_FLOAT, ang_accel_ref_q, &self.indi.angular_accel_ref.q)
LOG_ADD(LOG_FLOAT, ang_accel_ref_r, &self.indi.angular_accel_ref.r)
LOG_ADD(LOG_FLOAT, rate_d[0], &self.indi.rate_d[0])
LOG_ADD(LOG_FLOAT, rate_d[1], &self.indi.rate_d[1])
LOG_ADD(LOG_FLOAT, rate_d[2], &self.indi.rate_d[2])
LOG_ADD(LOG_FLOAT, uf_p, &self.indi.u[0].o[0])
LOG_ADD(LOG_FLOAT, uf_q, &self.indi.u[1].o[0])
LOG_ADD(LOG_FLOAT, uf_r, &self.indi.u[2].o[0])
LOG_ADD(LOG_FLOAT, Omega_f_p, &self.indi.rate[0].o[0])
LOG_ADD(LOG_FLOAT, Omega_f_q, &self.indi.rate[1].o[0])
LOG_ADD(LOG_FLOAT, Omega_f_r, &self.indi.rate[2].o[0])
LOG_ADD(LOG_FLOAT, n_p, &self.attitudeDesired.roll)
LOG_ADD(LOG_FLOAT, n_q, &self.attitudeDesired.pitch)
LOG_ADD(LOG_FLOAT, n_r, &self.attitudeDesired.yaw)
LOG_GROUP_STOP(ctrlINDI)
