/* The firmware's functions on file-scope state, for apps, over the state of the builtin provider.
 */
#include "app/include/attitude_controller.h"
#include "app/include/controller.h"
#include "app/include/controller_lee.h"
#include "app/include/controller_mellinger.h"
#include "app/include/controller_pid.h"
#include "app/include/estimator.h"
#include "app/include/estimator_complementary.h"
#include "app/include/position_controller.h"
#include "app/include/power_distribution.h"
#include "app/include/sensfusion6.h"
#include "library/builtin_adapter.h"
#include "library/inner.h"

#define DRONE (&cf_library_builtin)

// ------------------------------------------------------------------------------------ PID cascade

void controllerPidInit(void) {
  cf_controller_pid_reinit(&DRONE->pid);
}

bool controllerPidTest(void) {
  return attitudeControllerTest();
}

void controllerPid(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                   const state_t *state, const stabilizerStep_t stabilizerStep) {
  cf_controller_pid_update(&DRONE->pid, control, setpoint, sensors, state, stabilizerStep);
}

void attitudeControllerInit(const float updateDt) {
  (void)updateDt;
}

bool attitudeControllerTest(void) {
  return true;
}

void attitudeControllerCorrectAttitudePID(float eulerRollActual, float eulerPitchActual,
                                          float eulerYawActual, float eulerRollDesired,
                                          float eulerPitchDesired, float eulerYawDesired,
                                          float *rollRateDesired, float *pitchRateDesired,
                                          float *yawRateDesired) {
  const attitude_t measured = {
      .roll = eulerRollActual, .pitch = eulerPitchActual, .yaw = eulerYawActual};
  const attitude_t desired = {
      .roll = eulerRollDesired, .pitch = eulerPitchDesired, .yaw = eulerYawDesired};
  attitude_t rate;
  cf_attitude_controller_correct_attitude(&DRONE->pid.attitude, &measured, &desired, &rate);
  *rollRateDesired  = rate.roll;
  *pitchRateDesired = rate.pitch;
  *yawRateDesired   = rate.yaw;
}

void attitudeControllerCorrectRatePID(float rollRateActual, float pitchRateActual,
                                      float yawRateActual, float rollRateDesired,
                                      float pitchRateDesired, float yawRateDesired) {
  const attitude_t measured = {
      .roll = rollRateActual, .pitch = pitchRateActual, .yaw = yawRateActual};
  const attitude_t desired = {
      .roll = rollRateDesired, .pitch = pitchRateDesired, .yaw = yawRateDesired};
  cf_attitude_controller_correct_rate(&DRONE->pid.attitude, &measured, &desired);
}

void attitudeControllerResetRollAttitudePID(float rollActual) {
  cf_attitude_controller_reset_roll(&DRONE->pid.attitude, rollActual);
}

void attitudeControllerResetPitchAttitudePID(float pitchActual) {
  cf_attitude_controller_reset_pitch(&DRONE->pid.attitude, pitchActual);
}

void attitudeControllerResetAllPID(float rollActual, float pitchActual, float yawActual) {
  const attitude_t measured = {.roll = rollActual, .pitch = pitchActual, .yaw = yawActual};
  cf_attitude_controller_reset(&DRONE->pid.attitude, &measured);
}

void attitudeControllerGetActuatorOutput(int16_t *roll, int16_t *pitch, int16_t *yaw) {
  *roll  = DRONE->pid.attitude.roll_output;
  *pitch = DRONE->pid.attitude.pitch_output;
  *yaw   = DRONE->pid.attitude.yaw_output;
}

float attitudeControllerGetYawMaxDelta(void) {
  return DRONE->pid.attitude.yaw_max_delta;
}

void positionControllerInit(void) {
  cf_position_controller_reinit(&DRONE->pid.position);
}

void positionControllerResetAllPID(float xActual, float yActual, float zActual) {
  cf_position_controller_reset(&DRONE->pid.position, xActual, yActual, zActual);
}

void positionControllerResetAllfilters(void) {
  cf_position_controller_reset_filters(&DRONE->pid.position);
}

void positionController(float *thrust, attitude_t *attitude, const setpoint_t *setpoint,
                        const state_t *state) {
  cf_position_controller_update(&DRONE->pid.position, thrust, attitude, setpoint, state);
}

void velocityController(float *thrust, attitude_t *attitude, const Axis3f *setpoint_velocity,
                        const state_t *state) {
  cf_position_controller_update_velocity(&DRONE->pid.position, thrust, attitude, setpoint_velocity,
                                         state);
}

// ------------------------------------------------------------------------------ other controllers

ControllerType controllerGetType(void) {
  return (ControllerType)cf_library_inner()->controller_type(DRONE);
}

const char *controllerGetName(void) {
  return cf_library_inner()->controller_name((int)controllerGetType());
}

void controllerMellingerFirmwareInit(void) {
  controllerMellingerReset(&DRONE->mellinger);
}

bool controllerMellingerFirmwareTest(void) {
  return controllerMellingerTest(&DRONE->mellinger);
}

void controllerMellingerFirmware(control_t *control, const setpoint_t *setpoint,
                                 const sensorData_t *sensors, const state_t *state,
                                 const stabilizerStep_t stabilizerStep) {
  controllerMellinger(&DRONE->mellinger, control, setpoint, sensors, state, stabilizerStep);
}

void controllerLeeFirmwareInit(void) {
  controllerLeeReset(&DRONE->lee);
}

bool controllerLeeFirmwareTest(void) {
  return true;
}

void controllerLeeFirmware(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep) {
  controllerLee(&DRONE->lee, control, setpoint, sensors, state, stabilizerStep);
}

// Those of label.h: the names in C are taken by api/ here.
void cf_app_controllerINDIInit(void);
bool cf_app_controllerINDITest(void);
void cf_app_controllerINDI(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep);
void cf_app_positionControllerINDIInit(void);
void cf_app_positionControllerINDI(const sensorData_t *sensors, const setpoint_t *setpoint,
                                   const state_t *state, vector_t *refOuterINDI);
void cf_app_controllerBrescianiniInit(void);
bool cf_app_controllerBrescianiniTest(void);
void cf_app_controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                                  const sensorData_t *sensors, const state_t *state,
                                  const stabilizerStep_t stabilizerStep);

void cf_app_controllerINDIInit(void) {
  controllerINDIInit(&DRONE->indi, &DRONE->pid);
}

bool cf_app_controllerINDITest(void) {
  return controllerINDITest(&DRONE->indi);
}

void cf_app_controllerINDI(control_t *control, const setpoint_t *setpoint,
                           const sensorData_t *sensors, const state_t *state,
                           const stabilizerStep_t stabilizerStep) {
  controllerINDI(&DRONE->indi, &DRONE->pid, control, setpoint, sensors, state, stabilizerStep);
}

void cf_app_positionControllerINDIInit(void) {
  positionControllerINDIInit(&DRONE->indi.position);
}

void cf_app_positionControllerINDI(const sensorData_t *sensors, const setpoint_t *setpoint,
                                   const state_t *state, vector_t *refOuterINDI) {
  positionControllerINDI(&DRONE->indi.position, sensors, setpoint, state, refOuterINDI);
}

void cf_app_controllerBrescianiniInit(void) {
  controllerBrescianiniInit(&DRONE->brescianini);
}

bool cf_app_controllerBrescianiniTest(void) {
  return controllerBrescianiniTest(&DRONE->brescianini);
}

void cf_app_controllerBrescianini(control_t *control, const setpoint_t *setpoint,
                                  const sensorData_t *sensors, const state_t *state,
                                  const stabilizerStep_t stabilizerStep) {
  controllerBrescianini(&DRONE->brescianini, control, setpoint, sensors, state, stabilizerStep);
}

// ------------------------------------------------------------------------------------------ mixer

void powerDistributionInit(void) {
}

bool powerDistributionTest(void) {
  return true;
}

void powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped) {
  cf_power_distribution_update(&DRONE->power, control, motorThrustUncapped);
}

bool powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm) {
  return cf_power_distribution_cap(&DRONE->power, motorThrustBatCompUncapped, motorPwm);
}

int powerDistributionMotorType(uint32_t id) {
  (void)id;
  return 1;
}

uint16_t powerDistributionStopRatio(uint32_t id) {
  (void)id;
  return 0;
}

uint32_t powerDistributionGetIdleThrust(void) {
  return cf_power_distribution_idle_thrust(&DRONE->power);
}

float powerDistributionGetMaxThrust(void) {
  return cf_power_distribution_max_thrust(&DRONE->power);
}

// For platform_defaults.h.
const cf_platform_facts_t *cf_app_airframe(void);

const cf_platform_facts_t *cf_app_airframe(void) {
  return cf_platform_facts(DRONE->platform);
}

// -------------------------------------------------------------------------------------- estimators

// what estimatorComplementary() read last, a part of the image
static cf_latest_samples_t latest;

void estimatorComplementaryInit(void) {
  cf_complementary_init(&DRONE->complementary);
}

bool estimatorComplementaryTest(void) {
  return sensfusion6Test();
}

static void take(const measurement_t *measurement) {
  switch (measurement->type) {
    case MeasurementTypeGyroscope:
      latest.gyro = measurement->data.gyroscope.gyro;
      break;
    case MeasurementTypeAcceleration:
      latest.acc = measurement->data.acceleration.acc;
      break;
    case MeasurementTypeBarometer:
      latest.baro = measurement->data.barometer.baro;
      break;
    case MeasurementTypeTOF:
      latest.tof = measurement->data.tof;
      break;
    default:
      break;
  }
}

void estimatorComplementary(state_t *state, const stabilizerStep_t stabilizerStep) {
  measurement_t measurement;
  while (estimatorDequeue(&measurement)) {
    take(&measurement);
  }
  cf_complementary_update(&DRONE->complementary, &latest, state, stabilizerStep,
                          cf_library_now_ms());
}

void sensfusion6Init(void) {
  cf_sensfusion6_init(&DRONE->complementary.attitude);
}

bool sensfusion6Test(void) {
  return cf_sensfusion6_test(&DRONE->complementary.attitude);
}

void sensfusion6UpdateQ(float gx, float gy, float gz, float ax, float ay, float az, float dt) {
  cf_sensfusion6_update_q(&DRONE->complementary.attitude, gx, gy, gz, ax, ay, az, dt);
}

void sensfusion6GetQuaternion(float *qx, float *qy, float *qz, float *qw) {
  cf_sensfusion6_get_quaternion(&DRONE->complementary.attitude, qx, qy, qz, qw);
}

void sensfusion6GetEulerRPY(float *roll, float *pitch, float *yaw) {
  cf_sensfusion6_get_euler_rpy(&DRONE->complementary.attitude, roll, pitch, yaw);
}

float sensfusion6GetAccZWithoutGravity(const float ax, const float ay, const float az) {
  return cf_sensfusion6_get_acc_z_without_gravity(&DRONE->complementary.attitude, ax, ay, az);
}
