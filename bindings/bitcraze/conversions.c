
#include "bitcraze/conversions.h"

#include <string.h>

#define TIMED_XYZ(from_) \
  {.timestamp = (from_).timestamp, .x = (from_).x, .y = (from_).y, .z = (from_).z}
#define TIMED_ANGLES(from_) \
  {.timestamp = (from_).timestamp, .roll = (from_).roll, .pitch = (from_).pitch, .yaw = (from_).yaw}
#define QUATERNION(from_) {.x = (from_).x, .y = (from_).y, .z = (from_).z, .w = (from_).w}
#define AXES(from_) {.x = (from_).x, .y = (from_).y, .z = (from_).z}

// ------------------------------------------------------------------------------------- small ones

Axis3f cf_checkout_axes(const api_Axis3f *from) {
  return (Axis3f)AXES(*from);
}

baro_t cf_checkout_baro(const api_baro_t *from) {
  return (baro_t){.pressure = from->pressure, .temperature = from->temperature, .asl = from->asl};
}

struct vec cf_checkout_vec(struct api_vec from) {
  return mkvec(from.x, from.y, from.z);
}

struct traj_eval cf_checkout_start(const cf_plan_start_t *from) {
  struct traj_eval start = traj_eval_zero();
  start.pos              = cf_checkout_vec(from->pos);
  start.vel              = cf_checkout_vec(from->vel);
  start.yaw              = from->yaw;
  return start;
}

struct api_traj_eval cf_api_goal(const struct traj_eval *from) {
  return (struct api_traj_eval){
      .pos = AXES(from->pos),
      .vel = AXES(from->vel),
      .acc = AXES(from->acc),
#if HAVE_TRAJ_EVAL_JERK
      .jerk = AXES(from->jerk),
#endif
#if HAVE_TRAJ_EVAL_OMEGA
      .omega = AXES(from->omega),
#endif
      .yaw = from->yaw,
  };
}

// ----------------------------------------------------------------------------- setpoint, estimate

static stab_mode_t checkout_mode(api_stab_mode_t mode) {
  switch (mode) {
    case api_modeAbs:
      return modeAbs;
    case api_modeVelocity:
      return modeVelocity;
    default:
      return modeDisable;
  }
}

static api_stab_mode_t api_mode(stab_mode_t mode) {
  switch (mode) {
    case modeAbs:
      return api_modeAbs;
    case modeVelocity:
      return api_modeVelocity;
    default:
      return api_modeDisable;
  }
}

static attitude_t checkout_angles(const api_attitude_t *from) {
  return (attitude_t)TIMED_ANGLES(*from);
}

static api_attitude_t api_angles(const attitude_t *from) {
  return (api_attitude_t)TIMED_ANGLES(*from);
}

static struct vec3_s checkout_xyz(const struct api_vec3_s *from) {
  return (struct vec3_s)TIMED_XYZ(*from);
}

static struct api_vec3_s api_xyz(const struct vec3_s *from) {
  return (struct api_vec3_s)TIMED_XYZ(*from);
}

void cf_checkout_setpoint(setpoint_t *to, const api_setpoint_t *from) {
  memset(to, 0, sizeof *to);
  to->timestamp          = from->timestamp;
  to->attitude           = checkout_angles(&from->attitude);
  to->attitudeRate       = checkout_angles(&from->attitudeRate);
  to->attitudeQuaternion = (quaternion_t)QUATERNION(from->attitudeQuaternion);
  to->thrust             = from->thrust;
  to->position           = checkout_xyz(&from->position);
  to->velocity           = checkout_xyz(&from->velocity);
  to->acceleration       = checkout_xyz(&from->acceleration);
#if HAVE_SETPOINT_JERK
  to->jerk = checkout_xyz(&from->jerk);
#endif
  to->velocity_body = from->velocity_body;
  to->mode.x        = checkout_mode(from->mode.x);
  to->mode.y        = checkout_mode(from->mode.y);
  to->mode.z        = checkout_mode(from->mode.z);
  to->mode.roll     = checkout_mode(from->mode.roll);
  to->mode.pitch    = checkout_mode(from->mode.pitch);
  to->mode.yaw      = checkout_mode(from->mode.yaw);
  to->mode.quat     = checkout_mode(from->mode.quat);
}

void cf_api_setpoint(api_setpoint_t *to, const setpoint_t *from) {
  to->timestamp          = from->timestamp;
  to->attitude           = api_angles(&from->attitude);
  to->attitudeRate       = api_angles(&from->attitudeRate);
  to->attitudeQuaternion = (api_quaternion_t)QUATERNION(from->attitudeQuaternion);
  to->thrust             = from->thrust;
  to->position           = api_xyz(&from->position);
  to->velocity           = api_xyz(&from->velocity);
  to->acceleration       = api_xyz(&from->acceleration);
#if HAVE_SETPOINT_JERK
  to->jerk = api_xyz(&from->jerk);
#endif
  to->velocity_body = from->velocity_body;
  to->mode.x        = api_mode(from->mode.x);
  to->mode.y        = api_mode(from->mode.y);
  to->mode.z        = api_mode(from->mode.z);
  to->mode.roll     = api_mode(from->mode.roll);
  to->mode.pitch    = api_mode(from->mode.pitch);
  to->mode.yaw      = api_mode(from->mode.yaw);
  to->mode.quat     = api_mode(from->mode.quat);
}

state_t cf_checkout_state(const api_state_t *from) {
  return (state_t){
      .attitude           = TIMED_ANGLES(from->attitude),
      .attitudeQuaternion = QUATERNION(from->attitudeQuaternion),
      .position           = TIMED_XYZ(from->position),
      .velocity           = TIMED_XYZ(from->velocity),
      .acc                = TIMED_XYZ(from->acc),
  };
}

void cf_api_state(api_state_t *to, const state_t *from) {
  *to = (api_state_t){
      .attitude           = TIMED_ANGLES(from->attitude),
      .attitudeQuaternion = QUATERNION(from->attitudeQuaternion),
      .position           = TIMED_XYZ(from->position),
      .velocity           = TIMED_XYZ(from->velocity),
      .acc                = TIMED_XYZ(from->acc),
  };
}

sensorData_t cf_checkout_sensors(const api_sensorData_t *from) {
  return (sensorData_t){
      .acc                = AXES(from->acc),
      .gyro               = AXES(from->gyro),
      .mag                = AXES(from->mag),
      .baro               = cf_checkout_baro(&from->baro),
      .interruptTimestamp = from->interruptTimestamp,
  };
}

// The three views of a control overlap; all of it is carried over, whichever is meant.
control_t cf_checkout_control(const api_control_t *from) {
  control_t to = {.controlMode = (control_mode_t)from->controlMode};
  memcpy(to.normalizedForces, from->normalizedForces, sizeof to.normalizedForces);
  return to;
}

void cf_api_control(api_control_t *to, const control_t *from) {
  to->controlMode = (api_control_mode_t)from->controlMode;
  memcpy(to->normalizedForces, from->normalizedForces, sizeof to->normalizedForces);
}

// ----------------------------------------------------------------------------------- measurements

tdoaMeasurement_t cf_checkout_tdoa(const api_tdoaMeasurement_t *from) {
  return (tdoaMeasurement_t){
      .anchorPositions = {TIMED_XYZ(from->anchorPositions[0]), TIMED_XYZ(from->anchorPositions[1])},
      .anchorIds       = {from->anchorIds[0], from->anchorIds[1]},
      .distanceDiff    = from->distanceDiff,
      .stdDev          = from->stdDev,
  };
}

positionMeasurement_t cf_checkout_position(const api_positionMeasurement_t *from) {
  return (positionMeasurement_t){
      .pos    = {from->pos[0], from->pos[1], from->pos[2]},
      .stdDev = from->stdDev,
      .source = from->source == api_MeasurementSourceLighthouse ? MeasurementSourceLighthouse
                                                                : MeasurementSourceLocationService,
  };
}

poseMeasurement_t cf_checkout_pose(const api_poseMeasurement_t *from) {
  return (poseMeasurement_t){
      .pos        = {from->pos[0], from->pos[1], from->pos[2]},
      .quat       = QUATERNION(from->quat),
      .stdDevPos  = from->stdDevPos,
      .stdDevQuat = from->stdDevQuat,
  };
}

distanceMeasurement_t cf_checkout_distance(const api_distanceMeasurement_t *from) {
  return (distanceMeasurement_t){
      .pos      = {from->pos[0], from->pos[1], from->pos[2]},
      .anchorId = from->anchorId,
      .distance = from->distance,
      .stdDev   = from->stdDev,
  };
}

tofMeasurement_t cf_checkout_tof(const api_tofMeasurement_t *from) {
  return (tofMeasurement_t){
      .timestamp = from->timestamp,
      .distance  = from->distance,
      .stdDev    = from->stdDev,
#if HAVE_TOF_CONE
      .coneHalfAngle = from->coneHalfAngle,
#endif
  };
}

heightMeasurement_t cf_checkout_height(const api_heightMeasurement_t *from) {
  return (heightMeasurement_t){
      .timestamp = from->timestamp,
      .height    = from->height,
      .stdDev    = from->stdDev,
  };
}

flowMeasurement_t cf_checkout_flow(const api_flowMeasurement_t *from) {
  return (flowMeasurement_t){
      .timestamp = from->timestamp,
      .dpixel    = {from->dpixel[0], from->dpixel[1]},
      .stdDevX   = from->stdDevX,
      .stdDevY   = from->stdDevY,
      .dt        = from->dt,
  };
}

yawErrorMeasurement_t cf_checkout_yaw_error(const api_yawErrorMeasurement_t *from) {
  return (yawErrorMeasurement_t){
      .timestamp = from->timestamp,
      .yawError  = from->yawError,
      .stdDev    = from->stdDev,
  };
}

// The checkout's own model of a base station, where it is part of the library; else the one that
// came with the measurement.
#if CF_WITH_LIGHTHOUSE_CALIBRATION && HAVE_LIGHTHOUSE_MODEL_LH2
#include "lighthouse_calibration.h"

static lighthouseCalibrationMeasurementModel_t model_of(const api_sweepAngleMeasurement_t *from) {
  return from->calibrationMeasurementModel != NULL ? lighthouseCalibrationMeasurementModelLh2
                                                   : NULL;
}
#else
_Static_assert(sizeof(lighthouseCalibrationSweep_t) == sizeof(api_lighthouseCalibrationSweep_t),
               "the model reads a calibration of the checkout as one of ours");

static lighthouseCalibrationMeasurementModel_t model_of(const api_sweepAngleMeasurement_t *from) {
  return (lighthouseCalibrationMeasurementModel_t)(void (*)(void))from->calibrationMeasurementModel;
}
#endif

sweepAngleMeasurement_t cf_checkout_sweep(const api_sweepAngleMeasurement_t *from,
                                          lighthouseCalibrationSweep_t      *calibration) {
  if (from->calib != NULL) {
    *calibration = (lighthouseCalibrationSweep_t){
        .phase     = from->calib->phase,
        .tilt      = from->calib->tilt,
        .curve     = from->calib->curve,
        .gibmag    = from->calib->gibmag,
        .gibphase  = from->calib->gibphase,
        .ogeemag   = from->calib->ogeemag,
        .ogeephase = from->calib->ogeephase,
    };
  }
  return (sweepAngleMeasurement_t){
      .timestamp                   = from->timestamp,
      .sensorPos                   = (const vec3d *)from->sensorPos,
      .rotorPos                    = (const vec3d *)from->rotorPos,
      .rotorRot                    = (const mat3d *)from->rotorRot,
      .rotorRotInv                 = (const mat3d *)from->rotorRotInv,
      .sensorId                    = from->sensorId,
      .baseStationId               = from->baseStationId,
      .sweepId                     = from->sweepId,
      .t                           = from->t,
      .measuredSweepAngle          = from->measuredSweepAngle,
      .stdDev                      = from->stdDev,
      .calib                       = from->calib != NULL ? calibration : NULL,
      .calibrationMeasurementModel = model_of(from),
  };
}
