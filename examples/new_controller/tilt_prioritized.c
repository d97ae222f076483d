/* A controller of our own: tilt first, heading later.
 *
 * Where a quadrotor flies to depends on where its thrust points, and not on its heading. So the
 * attitude error is split. The tilt, which turns the thrust the shortest way to where it should
 * point, is corrected with full strength; the heading gently, with a limited acceleration.
 * Around it, a PID loop on the position asks for an acceleration and adds that of the setpoint,
 * which the stock PID controller does not look at.
 *
 * Uses nothing but what apps in the firmware's app layer may use: the same file can be flashed
 * (CONFIG_CONTROLLER_OOT=y). It follows positions and velocities. A setpoint without them (a
 * pilot's angles) stops the motors. */
#include <math.h>
#include <stdbool.h>

#include "FreeRTOS.h"
#include "app.h"
#include "controller.h"
#include "log.h"
#include "math3d.h"
#include "param.h"
#include "physicalConstants.h"
#include "platform_defaults.h"
#include "task.h"

#define DT (1.0f / ATTITUDE_RATE)  // [s]

// Each of these is a parameter: change it in flight, or in a mission file.
static float mass     = CF_MASS;  // [kg]
static float drag     = 0.4f;     // [1/s], of the air: acceleration per speed
static float posP     = 16.0f;    // [1/s^2]
static float posD     = 5.5f;     // [1/s]
static float posI     = 0.5f;     // [1/s^3]
static float tiltP    = 400.0f;   // [1/s^2]
static float tiltD    = 60.0f;    // [1/s]
static float headP    = 60.0f;    // [1/s^2]
static float headD    = 15.0f;    // [1/s]
static float headMax  = 40.0f;    // [rad/s^2], no more for the heading than this
static float tiltMax  = 35.0f;    // [deg], of the thrust it asks for
static float boundOfI = 1.0f;     // [m s]

static const struct vec INERTIA = {16.6e-6f, 16.7e-6f, 29.3e-6f};  // [kg m^2]

// What it remembers from call to call, and what it shows. Every drone has its own.
static struct vec integral;   // [m s]
static struct vec error;      // [m]
static float      tiltError;  // [deg]
static float      headError;  // [deg]
static float      thrust;     // [N]

void controllerOutOfTreeInit(void) {
  integral = vzero();
}

bool controllerOutOfTreeTest(void) {
  return true;
}

// Error of one axis: an absolute setpoint has one, a velocity setpoint has not.
static float distance(stab_mode_t mode, float wanted, float is) {
  return mode == modeAbs ? wanted - is : 0.0f;
}

// The acceleration [m/s^2] that the motors have to make, gravity included, in world axes.
static struct vec acceleration(const setpoint_t *setpoint, const state_t *state) {
  struct vec velocity = mkvec(setpoint->velocity.x, setpoint->velocity.y, setpoint->velocity.z);
  if (setpoint->velocity_body) {
    velocity = mvmul(mrotz(radians(state->attitude.yaw)), velocity);
  }
  error    = mkvec(distance(setpoint->mode.x, setpoint->position.x, state->position.x),
                   distance(setpoint->mode.y, setpoint->position.y, state->position.y),
                   distance(setpoint->mode.z, setpoint->position.z, state->position.z));
  integral = vclampabs(vadd(integral, vscl(DT, error)), vrepeat(boundOfI));

  const struct vec slip =
      vsub(velocity, mkvec(state->velocity.x, state->velocity.y, state->velocity.z));
  const struct vec feedForward =
      vadd(vscl(drag, velocity), mkvec(setpoint->acceleration.x, setpoint->acceleration.y,
                                       setpoint->acceleration.z + GRAVITY_MAGNITUDE));
  struct vec a = vadd4(vscl(posP, error), vscl(posD, slip), vscl(posI, integral), feedForward);

  // never downwards, and never further to the side than tiltMax
  a.z               = fmaxf(a.z, 0.3f * GRAVITY_MAGNITUDE);
  const float most  = a.z * tanf(radians(tiltMax));
  const float aside = sqrtf(fsqr(a.x) + fsqr(a.y));
  const float scale = aside > most ? most / aside : 1.0f;
  return mkvec(scale * a.x, scale * a.y, a.z);
}

// Turns [rad], in body axes, that point the thrust along `up`: about x and y only.
static struct vec tilt(struct quat attitude, struct vec up) {
  const struct vec goal = qvrot(qinv(attitude), up);
  const float      sine = sqrtf(fsqr(goal.x) + fsqr(goal.y));
  const float      turn = atan2f(sine, goal.z);
  const float      gain = sine > 1e-6f ? turn / sine : 1.0f;
  tiltError             = degrees(turn);
  return mkvec(-gain * goal.y, gain * goal.x, 0.0f);
}

static float desiredYaw(const setpoint_t *setpoint, const state_t *state) {
  if (setpoint->mode.yaw == modeAbs) {
    return setpoint->attitude.yaw;
  }
  if (setpoint->mode.quat == modeAbs) {
    const quaternion_t *q = &setpoint->attitudeQuaternion;
    return degrees(quat2rpy(mkquat(q->x, q->y, q->z, q->w)).z);
  }
  return state->attitude.yaw;  // a yaw rate: only the rate is followed
}

void controllerOutOfTree(control_t *control, const setpoint_t *setpoint,
                         const sensorData_t *sensors, const state_t *state,
                         const stabilizerStep_t stabilizerStep) {
  if (!RATE_DO_EXECUTE(ATTITUDE_RATE, stabilizerStep)) {
    return;
  }
  control->controlMode = controlModeForceTorque;
  if (setpoint->mode.z == modeDisable) {
    integral          = vzero();
    control->thrustSi = thrust = 0.0f;
    vstoref(vzero(), control->torque);
    return;
  }

  const quaternion_t *q        = &state->attitudeQuaternion;
  const struct quat   attitude = mkquat(q->x, q->y, q->z, q->w);
  const struct vec    a        = acceleration(setpoint, state);
  const struct vec    turn     = tilt(attitude, vnormalize(a));
  const struct vec    rates =
      mkvec(radians(sensors->gyro.x), radians(sensors->gyro.y), radians(sensors->gyro.z));

  // only the part of the wanted acceleration along the thrust can be had at once
  thrust = mass * vdot(a, qvrot(attitude, vbasis(2)));

  const float yawRate = setpoint->mode.yaw == modeVelocity ? setpoint->attitudeRate.yaw : 0.0f;
  headError        = degrees(shortest_signed_angle_radians(radians(state->attitude.yaw),
                                                           radians(desiredYaw(setpoint, state))));
  const float head = headP * radians(headError) + headD * (radians(yawRate) - rates.z);

  const struct vec spin = mkvec(tiltP * turn.x - tiltD * rates.x, tiltP * turn.y - tiltD * rates.y,
                                clamp(head, -headMax, headMax));
  control->thrustSi     = fmaxf(thrust, 0.0f);
  vstoref(veltmul(INERTIA, spin), control->torque);
}

// The firmware's app layer starts this as a task of its own. There is nothing for it to do.
void appMain(void) {
  while (1) {
    vTaskDelay(M2T(1000));
  }
}

PARAM_GROUP_START(ctrlTilt)
PARAM_ADD(PARAM_FLOAT, mass, &mass)
PARAM_ADD(PARAM_FLOAT, drag, &drag)
PARAM_ADD(PARAM_FLOAT, posP, &posP)
PARAM_ADD(PARAM_FLOAT, posD, &posD)
PARAM_ADD(PARAM_FLOAT, posI, &posI)
PARAM_ADD(PARAM_FLOAT, tiltP, &tiltP)
PARAM_ADD(PARAM_FLOAT, tiltD, &tiltD)
PARAM_ADD(PARAM_FLOAT, headP, &headP)
PARAM_ADD(PARAM_FLOAT, headD, &headD)
PARAM_ADD(PARAM_FLOAT, headMax, &headMax)
PARAM_ADD(PARAM_FLOAT, tiltMax, &tiltMax)
PARAM_GROUP_STOP(ctrlTilt)

LOG_GROUP_START(ctrlTilt)
LOG_ADD(LOG_FLOAT, errX, &error.x)
LOG_ADD(LOG_FLOAT, errY, &error.y)
LOG_ADD(LOG_FLOAT, errZ, &error.z)
LOG_ADD(LOG_FLOAT, tilt, &tiltError)
LOG_ADD(LOG_FLOAT, head, &headError)
LOG_ADD(LOG_FLOAT, thrust, &thrust)
LOG_GROUP_STOP(ctrlTilt)
