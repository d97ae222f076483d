// clang-format off
#include <math.h>
#include "num.h"

#include "log.h"
#include "param.h"
#include "pid.h"
#include "position_controller.h"
#include "platform_defaults.h"
// clang-format on

struct pidAxis_s {
  PidObject   pid;
  stab_mode_t previousMode;
  float       setpoint;
  float       output;
};

struct this_s {
  struct pidAxis_s pidVX;
  struct pidAxis_s pidVY;
  struct pidAxis_s pidVZ;
  struct pidAxis_s pidX;
  struct pidAxis_s pidY;
  struct pidAxis_s pidZ;

  uint16_t thrustBase;  // about what it takes to hover
  uint16_t thrustMin;
};

static float       rLimit          = PID_VEL_ROLL_MAX;
static float       pLimit          = PID_VEL_PITCH_MAX;
static float       rpLimitOverhead = 1.10f;
static float       xVelMax         = PID_POS_VEL_X_MAX;
static float       yVelMax         = PID_POS_VEL_Y_MAX;
static float       zVelMax         = PID_POS_VEL_Z_MAX;
static float       velMaxOverhead  = 1.10f;
static const float thrustScale     = 1000.0f;
static bool        posFiltEnable   = PID_POS_XY_FILT_ENABLE;
static float       posFiltCutoff   = PID_POS_XY_FILT_CUTOFF;
static bool        posZFiltEnable  = PID_POS_Z_FILT_ENABLE;
static float       posZFiltCutoff  = PID_POS_Z_FILT_CUTOFF;
static bool        velFiltEnable   = PID_VEL_XY_FILT_ENABLE;
static float       velFiltCutoff   = PID_VEL_XY_FILT_CUTOFF;
static bool        velZFiltEnable  = PID_VEL_Z_FILT_ENABLE;
static float       velZFiltCutoff  = PID_VEL_Z_FILT_CUTOFF;

#define DT (float)(1.0f / POSITION_RATE)

#define GAINS(axis)                  \
  {                                  \
    .pid = {.kp  = PID_##axis##_KP,  \
            .ki  = PID_##axis##_KI,  \
            .kd  = PID_##axis##_KD,  \
            .kff = PID_##axis##_KFF, \
            .dt  = DT}               \
  }

static struct this_s this = {
    .pidVX      = GAINS(VEL_X),
    .pidVY      = GAINS(VEL_Y),
    .pidVZ      = GAINS(VEL_Z),
    .pidX       = GAINS(POS_X),
    .pidY       = GAINS(POS_Y),
    .pidZ       = GAINS(POS_Z),
    .thrustBase = PID_VEL_THRUST_BASE,
    .thrustMin  = PID_VEL_THRUST_MIN,
};

float state_body_x, state_body_y, state_body_vx, state_body_vy;

static void initAxis(struct pidAxis_s *axis, float cutoff, bool filtered) {
  pidInit(&axis->pid, axis->setpoint, axis->pid.kp, axis->pid.ki, axis->pid.kd, axis->pid.kff, DT,
          POSITION_RATE, cutoff, filtered);
}

void positionControllerInit() {
  initAxis(&this.pidX, posFiltCutoff, posFiltEnable);
  initAxis(&this.pidY, posFiltCutoff, posFiltEnable);
  initAxis(&this.pidZ, posZFiltCutoff, posZFiltEnable);
  initAxis(&this.pidVX, velFiltCutoff, velFiltEnable);
  initAxis(&this.pidVY, velFiltCutoff, velFiltEnable);
  initAxis(&this.pidVZ, velZFiltCutoff, velZFiltEnable);
}

static float runPid(float input, struct pidAxis_s *axis, float setpoint) {
  axis->setpoint = setpoint;
  pidSetDesired(&axis->pid, axis->setpoint);
  return pidUpdate(&axis->pid, input, false);
}

void positionController(float *thrust, attitude_t *attitude, const setpoint_t *setpoint,
                        const state_t *state) {
  this.pidX.pid.outputLimit = xVelMax * velMaxOverhead;
  this.pidY.pid.outputLimit = yVelMax * velMaxOverhead;
  this.pidZ.pid.outputLimit = fmaxf(zVelMax, 0.5f) * velMaxOverhead;

  const float yaw = state->attitude.yaw * (float)M_PI / 180.0f;
  const float c   = cosf(yaw);
  const float s   = sinf(yaw);

  const float setp_body_x = setpoint->position.x * c + setpoint->position.y * s;
  const float setp_body_y = -setpoint->position.x * s + setpoint->position.y * c;
  state_body_x            = state->position.x * c + state->position.y * s;
  state_body_y            = -state->position.x * s + state->position.y * c;

  Axis3f velocity = {.axis = {setpoint->velocity.x, setpoint->velocity.y, setpoint->velocity.z}};
  if (setpoint->mode.x == modeAbs) {
    velocity.x = runPid(state_body_x, &this.pidX, setp_body_x);
  } else if (!setpoint->velocity_body) {
    velocity.x = setpoint->velocity.x * c + setpoint->velocity.y * s;
  }
  if (setpoint->mode.y == modeAbs) {
    velocity.y = runPid(state_body_y, &this.pidY, setp_body_y);
  } else if (!setpoint->velocity_body) {
    velocity.y = -setpoint->velocity.x * s + setpoint->velocity.y * c;
  }
  if (setpoint->mode.z == modeAbs) {
    velocity.z = runPid(state->position.z, &this.pidZ, setpoint->position.z);
  }
  velocityController(thrust, attitude, &velocity, state);
}

void velocityController(float *thrust, attitude_t *attitude, const Axis3f *setpoint_velocity,
                        const state_t *state) {
  this.pidVX.pid.outputLimit = pLimit * rpLimitOverhead;
  this.pidVY.pid.outputLimit = rLimit * rpLimitOverhead;
  this.pidVZ.pid.outputLimit = (UINT16_MAX / 2 / thrustScale);

  const float yaw = state->attitude.yaw * (float)M_PI / 180.0f;
  const float c   = cosf(yaw);
  const float s   = sinf(yaw);
  state_body_vx   = state->velocity.x * c + state->velocity.y * s;
  state_body_vy   = -state->velocity.x * s + state->velocity.y * c;

  attitude->pitch = -runPid(state_body_vx, &this.pidVX, setpoint_velocity->x);
  attitude->roll  = -runPid(state_body_vy, &this.pidVY, setpoint_velocity->y);
  attitude->roll  = constrain(attitude->roll, -rLimit, rLimit);
  attitude->pitch = constrain(attitude->pitch, -pLimit, pLimit);

  const float thrustRaw = runPid(state->velocity.z, &this.pidVZ, setpoint_velocity->z);
  *thrust               = thrustRaw * thrustScale + this.thrustBase;
  if (*thrust < this.thrustMin) {
    *thrust = this.thrustMin;
  }
  *thrust = constrain(*thrust, 0, UINT16_MAX);
}

#if MINIATURE_RELEASE >= 202502
void positionControllerResetAllPID(float xActual, float yActual, float zActual) {
  pidReset(&this.pidX.pid, xActual);
  pidReset(&this.pidY.pid, yActual);
  pidReset(&this.pidZ.pid, zActual);
  pidReset(&this.pidVX.pid, 0);
  pidReset(&this.pidVY.pid, 0);
  pidReset(&this.pidVZ.pid, 0);
}
#else
void positionControllerResetAllPID() {
  pidReset(&this.pidX.pid);
  pidReset(&this.pidY.pid);
  pidReset(&this.pidZ.pid);
  pidReset(&this.pidVX.pid);
  pidReset(&this.pidVY.pid);
  pidReset(&this.pidVZ.pid);
}
#endif

void positionControllerResetAllfilters() {
  filterReset(&this.pidX.pid, POSITION_RATE, posFiltCutoff, posFiltEnable);
  filterReset(&this.pidY.pid, POSITION_RATE, posFiltCutoff, posFiltEnable);
  filterReset(&this.pidZ.pid, POSITION_RATE, posZFiltCutoff, posZFiltEnable);
  filterReset(&this.pidVX.pid, POSITION_RATE, velFiltCutoff, velFiltEnable);
  filterReset(&this.pidVY.pid, POSITION_RATE, velFiltCutoff, velFiltEnable);
  filterReset(&this.pidVZ.pid, POSITION_RATE, velZFiltCutoff, velZFiltEnable);
}

#define LOG_TERMS(axis)                                 \
  LOG_ADD(LOG_FLOAT, axis##p, &this.pid##axis.pid.outP) \
  LOG_ADD(LOG_FLOAT, axis##i, &this.pid##axis.pid.outI) \
  LOG_ADD(LOG_FLOAT, axis##d, &this.pid##axis.pid.outD) \
  LOG_ADD(LOG_FLOAT, axis##ff, &this.pid##axis.pid.outFF)

LOG_GROUP_START(posCtl)
LOG_ADD(LOG_FLOAT, targetVX, &this.pidVX.pid.desired)
LOG_ADD(LOG_FLOAT, targetVY, &this.pidVY.pid.desired)
LOG_ADD(LOG_FLOAT, targetVZ, &this.pidVZ.pid.desired)
LOG_ADD(LOG_FLOAT, targetX, &this.pidX.pid.desired)
LOG_ADD(LOG_FLOAT, targetY, &this.pidY.pid.desired)
LOG_ADD(LOG_FLOAT, targetZ, &this.pidZ.pid.desired)
LOG_ADD(LOG_FLOAT, bodyVX, &state_body_vx)
LOG_ADD(LOG_FLOAT, bodyVY, &state_body_vy)
LOG_ADD(LOG_FLOAT, bodyX, &state_body_x)
LOG_ADD(LOG_FLOAT, bodyY, &state_body_y)
LOG_TERMS(X)
LOG_TERMS(Y)
LOG_TERMS(Z)
LOG_TERMS(VX)
LOG_TERMS(VY)
LOG_TERMS(VZ)
LOG_GROUP_STOP(posCtl)

#define PARAM_GAINS(axis, kff_name, object)                                \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##Kp, &this.object.pid.kp) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##Ki, &this.object.pid.ki) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##Kd, &this.object.pid.kd) \
  PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, axis##kff_name, &this.object.pid.kff)

PARAM_GROUP_START(velCtlPid)
PARAM_GAINS(vx, KFF, pidVX)
PARAM_GAINS(vy, KFF, pidVY)
PARAM_GAINS(vz, KFF, pidVZ)
PARAM_GROUP_STOP(velCtlPid)

PARAM_GROUP_START(posCtlPid)
PARAM_GAINS(x, Kff, pidX)
PARAM_GAINS(y, Kff, pidY)
PARAM_GAINS(z, Kff, pidZ)
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, thrustBase, &this.thrustBase)
PARAM_ADD(PARAM_UINT16 | PARAM_PERSISTENT, thrustMin, &this.thrustMin)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, rLimit, &rLimit)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, pLimit, &pLimit)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, xVelMax, &xVelMax)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, yVelMax, &yVelMax)
PARAM_ADD(PARAM_FLOAT | PARAM_PERSISTENT, zVelMax, &zVelMax)
PARAM_GROUP_STOP(posCtlPid)
