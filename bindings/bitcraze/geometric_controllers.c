
#include "bitcraze/geometric_controllers.h"

#include "log.h"
#include "param.h"

// -------------------------------------------------------------------------------------- Mellinger

#if CF_WITH_CONTROLLER_MELLINGER && CF_VEHICLE_MODE_CONTROLLER_MELLINGER
// declared by the checkout's header for the vehicle only
void controllerMellingerFirmwareInit(void);
void controllerMellingerFirmware(control_t *control, const setpoint_t *setpoint,
                                 const sensorData_t *sensors, const state_t *state,
                                 const stabilizerStep_t stabilizerStep);

static void boot_mellinger(void) {
}

void cf_mellinger_select(void) {
  controllerMellingerFirmwareInit();
}

void cf_mellinger_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                      const state_t *state, const stabilizerStep_t stabilizerStep) {
  controllerMellingerFirmware(control, setpoint, sensors, state, stabilizerStep);
}
#elif CF_WITH_CONTROLLER_MELLINGER
#include "controller_mellinger.h"

static controllerMellinger_t mellinger;

static void boot_mellinger(void) {
  controllerMellingerInit(&mellinger);
}

// controllerMellingerInit() would take the gains of the default instance again
void cf_mellinger_select(void) {
  mellinger.i_error_x   = 0;
  mellinger.i_error_y   = 0;
  mellinger.i_error_z   = 0;
  mellinger.i_error_m_x = 0;
  mellinger.i_error_m_y = 0;
  mellinger.i_error_m_z = 0;
}

void cf_mellinger_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                      const state_t *state, const stabilizerStep_t stabilizerStep) {
  controllerMellinger(&mellinger, control, setpoint, sensors, state, stabilizerStep);
}

PARAM_GROUP_START(ctrlMel)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kp_xy, &mellinger.kp_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kd_xy, &mellinger.kd_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki_xy, &mellinger.ki_xy)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, i_range_xy, &mellinger.i_range_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kp_z, &mellinger.kp_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kd_z, &mellinger.kd_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki_z, &mellinger.ki_z)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, i_range_z, &mellinger.i_range_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, mass, &mellinger.mass)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, massThrust, &mellinger.massThrust)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kR_xy, &mellinger.kR_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kR_z, &mellinger.kR_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kw_xy, &mellinger.kw_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kw_z, &mellinger.kw_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki_m_xy, &mellinger.ki_m_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki_m_z, &mellinger.ki_m_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kd_omega_rp, &mellinger.kd_omega_rp)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, i_range_m_xy, &mellinger.i_range_m_xy)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, i_range_m_z, &mellinger.i_range_m_z)
PARAM_GROUP_STOP(ctrlMel)

LOG_GROUP_START(ctrlMel)
LOG_ADD(LOG_FLOAT, cmd_thrust, &mellinger.cmd_thrust)
LOG_ADD(LOG_FLOAT, cmd_roll, &mellinger.cmd_roll)
LOG_ADD(LOG_FLOAT, cmd_pitch, &mellinger.cmd_pitch)
LOG_ADD(LOG_FLOAT, cmd_yaw, &mellinger.cmd_yaw)
LOG_ADD(LOG_FLOAT, r_roll, &mellinger.r_roll)
LOG_ADD(LOG_FLOAT, r_pitch, &mellinger.r_pitch)
LOG_ADD(LOG_FLOAT, r_yaw, &mellinger.r_yaw)
LOG_ADD(LOG_FLOAT, accelz, &mellinger.accelz)
LOG_ADD(LOG_FLOAT, zdx, &mellinger.z_axis_desired.x)
LOG_ADD(LOG_FLOAT, zdy, &mellinger.z_axis_desired.y)
LOG_ADD(LOG_FLOAT, zdz, &mellinger.z_axis_desired.z)
LOG_ADD(LOG_FLOAT, i_err_x, &mellinger.i_error_x)
LOG_ADD(LOG_FLOAT, i_err_y, &mellinger.i_error_y)
LOG_ADD(LOG_FLOAT, i_err_z, &mellinger.i_error_z)
LOG_GROUP_STOP(ctrlMel)
#else
static void boot_mellinger(void) {
}
#endif

// -------------------------------------------------------------------------------------------- Lee

#define HAS_LEE (CF_WITH_CONTROLLER_LEE && HAVE_CONTROLLER_LEE)

#if HAS_LEE && CF_VEHICLE_MODE_CONTROLLER_LEE
void controllerLeeFirmwareInit(void);
void controllerLeeFirmware(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state, const uint32_t tick);

static void boot_lee(void) {
}

void cf_lee_select(void) {
  controllerLeeFirmwareInit();
}

void cf_lee_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                const state_t *state, const stabilizerStep_t stabilizerStep) {
  controllerLeeFirmware(control, setpoint, sensors, state, stabilizerStep);
}
#elif HAS_LEE
#include "controller_lee.h"

static controllerLee_t lee;

static void boot_lee(void) {
  controllerLeeInit(&lee);
}

void cf_lee_select(void) {
  controllerLeeReset(&lee);
}

void cf_lee_run(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                const state_t *state, const stabilizerStep_t stabilizerStep) {
  controllerLee(&lee, control, setpoint, sensors, state, stabilizerStep);
}

PARAM_GROUP_START(ctrlLee)
PARAM_ADD(PARAM_FLOAT, KR_x, &lee.KR.x)
PARAM_ADD(PARAM_FLOAT, KR_y, &lee.KR.y)
PARAM_ADD(PARAM_FLOAT, KR_z, &lee.KR.z)
PARAM_ADD(PARAM_FLOAT, KI_x, &lee.KI.x)
PARAM_ADD(PARAM_FLOAT, KI_y, &lee.KI.y)
PARAM_ADD(PARAM_FLOAT, KI_z, &lee.KI.z)
PARAM_ADD(PARAM_FLOAT, Kw_x, &lee.Komega.x)
PARAM_ADD(PARAM_FLOAT, Kw_y, &lee.Komega.y)
PARAM_ADD(PARAM_FLOAT, Kw_z, &lee.Komega.z)
PARAM_ADD(PARAM_FLOAT, J_x, &lee.J.x)
PARAM_ADD(PARAM_FLOAT, J_y, &lee.J.y)
PARAM_ADD(PARAM_FLOAT, J_z, &lee.J.z)
PARAM_ADD(PARAM_FLOAT, Kpos_Px, &lee.Kpos_P.x)
PARAM_ADD(PARAM_FLOAT, Kpos_Py, &lee.Kpos_P.y)
PARAM_ADD(PARAM_FLOAT, Kpos_Pz, &lee.Kpos_P.z)
PARAM_ADD(PARAM_FLOAT, Kpos_P_limit, &lee.Kpos_P_limit)
PARAM_ADD(PARAM_FLOAT, Kpos_Dx, &lee.Kpos_D.x)
PARAM_ADD(PARAM_FLOAT, Kpos_Dy, &lee.Kpos_D.y)
PARAM_ADD(PARAM_FLOAT, Kpos_Dz, &lee.Kpos_D.z)
PARAM_ADD(PARAM_FLOAT, Kpos_D_limit, &lee.Kpos_D_limit)
PARAM_ADD(PARAM_FLOAT, Kpos_Ix, &lee.Kpos_I.x)
PARAM_ADD(PARAM_FLOAT, Kpos_Iy, &lee.Kpos_I.y)
PARAM_ADD(PARAM_FLOAT, Kpos_Iz, &lee.Kpos_I.z)
PARAM_ADD(PARAM_FLOAT, Kpos_I_limit, &lee.Kpos_I_limit)
PARAM_ADD(PARAM_FLOAT, mass, &lee.mass)
PARAM_GROUP_STOP(ctrlLee)

LOG_GROUP_START(ctrlLee)
LOG_ADD(LOG_FLOAT, KR_x, &lee.KR.x)
LOG_ADD(LOG_FLOAT, KR_y, &lee.KR.y)
LOG_ADD(LOG_FLOAT, KR_z, &lee.KR.z)
LOG_ADD(LOG_FLOAT, Kw_x, &lee.Komega.x)
LOG_ADD(LOG_FLOAT, Kw_y, &lee.Komega.y)
LOG_ADD(LOG_FLOAT, Kw_z, &lee.Komega.z)
LOG_ADD(LOG_FLOAT, Kpos_Px, &lee.Kpos_P.x)
LOG_ADD(LOG_FLOAT, Kpos_Py, &lee.Kpos_P.y)
LOG_ADD(LOG_FLOAT, Kpos_Pz, &lee.Kpos_P.z)
LOG_ADD(LOG_FLOAT, Kpos_Dx, &lee.Kpos_D.x)
LOG_ADD(LOG_FLOAT, Kpos_Dy, &lee.Kpos_D.y)
LOG_ADD(LOG_FLOAT, Kpos_Dz, &lee.Kpos_D.z)
LOG_ADD(LOG_FLOAT, thrustSi, &lee.thrustSi)
LOG_ADD(LOG_FLOAT, torquex, &lee.u.x)
LOG_ADD(LOG_FLOAT, torquey, &lee.u.y)
LOG_ADD(LOG_FLOAT, torquez, &lee.u.z)
LOG_ADD(LOG_FLOAT, rpyx, &lee.rpy.x)
LOG_ADD(LOG_FLOAT, rpyy, &lee.rpy.y)
LOG_ADD(LOG_FLOAT, rpyz, &lee.rpy.z)
LOG_ADD(LOG_FLOAT, rpydx, &lee.rpy_des.x)
LOG_ADD(LOG_FLOAT, rpydy, &lee.rpy_des.y)
LOG_ADD(LOG_FLOAT, rpydz, &lee.rpy_des.z)
LOG_ADD(LOG_FLOAT, error_posx, &lee.p_error.x)
LOG_ADD(LOG_FLOAT, error_posy, &lee.p_error.y)
LOG_ADD(LOG_FLOAT, error_posz, &lee.p_error.z)
LOG_ADD(LOG_FLOAT, error_velx, &lee.v_error.x)
LOG_ADD(LOG_FLOAT, error_vely, &lee.v_error.y)
LOG_ADD(LOG_FLOAT, error_velz, &lee.v_error.z)
LOG_ADD(LOG_FLOAT, omegax, &lee.omega.x)
LOG_ADD(LOG_FLOAT, omegay, &lee.omega.y)
LOG_ADD(LOG_FLOAT, omegaz, &lee.omega.z)
LOG_ADD(LOG_FLOAT, omegarx, &lee.omega_r.x)
LOG_ADD(LOG_FLOAT, omegary, &lee.omega_r.y)
LOG_ADD(LOG_FLOAT, omegarz, &lee.omega_r.z)
LOG_GROUP_STOP(ctrlLee)
#else
static void boot_lee(void) {
}
#endif

void cf_geometric_controllers_boot(void) {
  boot_mellinger();
  boot_lee();
}
