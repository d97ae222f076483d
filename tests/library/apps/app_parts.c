// Calls the loops of the PID controller, the mixer and the airframe one by one.

#include "app_modes.h"
#include "attitude_controller.h"
#include "controller.h"
#include "platform_defaults.h"
#include "position_controller.h"
#include "power_distribution.h"

void call_parts(const call_t *call) {
  int16_t roll, pitch, yaw;
  attitudeControllerInit(ATTITUDE_UPDATE_DT);
  attitudeControllerResetAllPID(0.0f, 0.0f, 0.0f);
  attitudeControllerCorrectRatePID(0.0f, 0.0f, 0.0f, 1.0f, 2.0f, 3.0f);
  attitudeControllerGetActuatorOutput(&roll, &pitch, &yaw);

  float roll_rate, pitch_rate, yaw_rate;
  attitudeControllerCorrectAttitudePID(0.0f, 0.0f, 0.0f, 1.0f, 2.0f, 3.0f, &roll_rate, &pitch_rate,
                                       &yaw_rate);

  float      thrust;
  attitude_t attitude;
  positionControllerInit();
  positionControllerResetAllPID(0.0f, 0.0f, 0.0f);
  positionControllerResetAllfilters();
  positionController(&thrust, &attitude, call->setpoint, call->state);

  const control_t          wanted = {.thrust = 1000.0f, .roll = roll, .pitch = pitch, .yaw = yaw};
  motors_thrust_uncapped_t uncapped;
  motors_thrust_pwm_t      pwm;
  powerDistribution(&wanted, &uncapped);
  powerDistributionCap(&uncapped, &pwm);

  control_t *control           = call->control;
  control->controlMode         = controlModeForce;
  control->normalizedForces[0] = (float)pwm.motors.m4;  // thrust + roll / 2 + pitch / 2 - yaw
  control->normalizedForces[1] = roll_rate;
  control->normalizedForces[2] = thrust;
  control->normalizedForces[3] = CF_MASS + powerDistributionGetMaxThrust();
  if (controllerGetType() != ControllerTypeOot || controllerGetName()[0] != 'O' ||
      powerDistributionGetMaxThrust() != 4.0f * THRUST_MAX || ARM_LENGTH < 0.04f) {
    control->normalizedForces[3] = 0.0f;
  }
}
