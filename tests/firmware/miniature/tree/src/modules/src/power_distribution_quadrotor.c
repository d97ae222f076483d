// clang-format off
#include "power_distribution.h"

#include <string.h>
#include "debug.h"
#include "log.h"
#include "param.h"
#include "num.h"
#include "autoconf.h"
#include "config.h"
#include "math.h"
#include "platform_defaults.h"
// clang-format on

#if (!defined(CONFIG_MOTORS_REQUIRE_ARMING) || (CONFIG_MOTORS_REQUIRE_ARMING == 0)) && \
    defined(CONFIG_MOTORS_DEFAULT_IDLE_THRUST) && (CONFIG_MOTORS_DEFAULT_IDLE_THRUST > 0)
#error "idle thrust spins the motors at once where no arming is required"
#endif

#ifndef CONFIG_MOTORS_DEFAULT_IDLE_THRUST
#define DEFAULT_IDLE_THRUST 0
#else
#define DEFAULT_IDLE_THRUST CONFIG_MOTORS_DEFAULT_IDLE_THRUST
#endif

static uint32_t idleThrust = DEFAULT_IDLE_THRUST;

int powerDistributionMotorType(uint32_t id) {
  (void)id;
  return 1;
}

uint16_t powerDistributionStopRatio(uint32_t id) {
  (void)id;
  return 0;
}

void powerDistributionInit(void) {
#if (!defined(CONFIG_MOTORS_REQUIRE_ARMING) || (CONFIG_MOTORS_REQUIRE_ARMING == 0))
  if (idleThrust > 0) {
    DEBUG_PRINT("WARNING: idle thrust %lu without arming\n", idleThrust);
  }
#endif
}

bool powerDistributionTest(void) {
  return true;
}

// a float that no int32 holds saturates, as on the vehicle's processor
static int32_t whole(float x) {
  if (!(x >= -2147483648.0f)) {
    return isnan(x) ? 0 : INT32_MIN;
  }
  return x >= 2147483648.0f ? INT32_MAX : (int32_t)x;
}

static void powerDistributionLegacy(const control_t          *control,
                                    motors_thrust_uncapped_t *motorThrustUncapped) {
  const int16_t r = control->roll / 2.0f;
  const int16_t p = control->pitch / 2.0f;

  motorThrustUncapped->motors.m1 = whole(control->thrust - r + p + control->yaw);
  motorThrustUncapped->motors.m2 = whole(control->thrust - r - p - control->yaw);
  motorThrustUncapped->motors.m3 = whole(control->thrust + r - p + control->yaw);
  motorThrustUncapped->motors.m4 = whole(control->thrust + r + p - control->yaw);
}

static void powerDistributionForceTorque(const control_t          *control,
                                         motors_thrust_uncapped_t *motorThrustUncapped) {
  static float motorForces[STABILIZER_NR_OF_MOTORS];

  const float arm        = 0.707106781f * ARM_LENGTH;
  const float rollPart   = 0.25f / arm * control->torqueX;
  const float pitchPart  = 0.25f / arm * control->torqueY;
  const float thrustPart = 0.25f * control->thrustSi;
  const float yawPart    = 0.25f * control->torqueZ / THRUST2TORQUE;

  motorForces[0] = thrustPart - rollPart - pitchPart - yawPart;
  motorForces[1] = thrustPart - rollPart + pitchPart + yawPart;
  motorForces[2] = thrustPart + rollPart + pitchPart - yawPart;
  motorForces[3] = thrustPart + rollPart - pitchPart + yawPart;
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    const float force            = motorForces[i] < 0.0f ? 0.0f : motorForces[i];
    motorThrustUncapped->list[i] = whole(force / THRUST_MAX * UINT16_MAX);
  }
}

static void powerDistributionForce(const control_t          *control,
                                   motors_thrust_uncapped_t *motorThrustUncapped) {
#if MINIATURE_RELEASE >= 202608
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    const float f                = constrain(control->normalizedForces[i], 0.0f, 1.0f);
    motorThrustUncapped->list[i] = whole(f * UINT16_MAX);
  }
#else
  // not yet implemented
  (void)control;
  (void)motorThrustUncapped;
#endif
}

void powerDistribution(const control_t *control, motors_thrust_uncapped_t *motorThrustUncapped) {
  switch (control->controlMode) {
    case controlModeLegacy:
      powerDistributionLegacy(control, motorThrustUncapped);
      break;
    case controlModeForceTorque:
      powerDistributionForceTorque(control, motorThrustUncapped);
      break;
    case controlModeForce:
#if MINIATURE_RELEASE >= 202608
    case controlModePWM:
#endif
      powerDistributionForce(control, motorThrustUncapped);
      break;
    default:
      break;
  }
}

static bool cap(const motors_thrust_uncapped_t *uncapped, motors_thrust_pwm_t *pwm) {
  const int32_t limit   = UINT16_MAX;
  int64_t       highest = 0;
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    highest = uncapped->list[i] > highest ? uncapped->list[i] : highest;
  }
  const int64_t reduction = highest > limit ? highest - limit : 0;
  for (int i = 0; i < STABILIZER_NR_OF_MOTORS; i++) {
    const int64_t reduced = uncapped->list[i] - reduction;
    pwm->list[i] =
        reduced < powerDistributionGetIdleThrust() ? powerDistributionGetIdleThrust() : reduced;
  }
  return reduction > 0;
}

#if MINIATURE_RELEASE >= 202512
bool powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm) {
  return cap(motorThrustBatCompUncapped, motorPwm);
}
#else
void powerDistributionCap(const motors_thrust_uncapped_t *motorThrustBatCompUncapped,
                          motors_thrust_pwm_t            *motorPwm) {
  cap(motorThrustBatCompUncapped, motorPwm);
}
#endif

uint32_t powerDistributionGetIdleThrust() {
#if defined(CONFIG_MOTORS_REQUIRE_ARMING) && CONFIG_MOTORS_REQUIRE_ARMING
  return idleThrust;
#else
  return 0;
#endif
}

#if MINIATURE_RELEASE >= 202512
float powerDistributionGetMaxThrust() {
  return STABILIZER_NR_OF_MOTORS * THRUST_MAX;
}
#endif

PARAM_GROUP_START(powerDist)
PARAM_ADD_CORE(PARAM_UINT32 | PARAM_PERSISTENT, idleThrust, &idleThrust)
PARAM_GROUP_STOP(powerDist)
