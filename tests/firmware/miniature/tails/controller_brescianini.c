// PRECISE_LANDING Brescianini
static bool isInit;

void controllerBrescianiniInit(void) {
  isInit = true;
}

bool controllerBrescianiniTest(void) {
  return isInit;
}

void controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep) {
  update(&self, control, setpoint, sensors, state, stabilizerStep);
}

PARAM_GROUP_START(ctrlAtt)
PARAM_ADD(PARAM_FLOAT, tau_xy, &self.tau_xy)
PARAM_ADD(PARAM_FLOAT, zeta_xy, &self.zeta_xy)
PARAM_ADD(PARAM_FLOAT, tau_z, &self.tau_z)
PARAM_ADD(PARAM_FLOAT, zeta_z, &self.zeta_z)
PARAM_ADD(PARAM_FLOAT, tau_rp, &self.tau_rp)
PARAM_ADD(PARAM_FLOAT, mixing_factor, &self.mixing_factor)
PARAM_ADD(PARAM_FLOAT, coll_fairness, &self.coll_fairness)
PARAM_GROUP_STOP(ctrlAtt)
