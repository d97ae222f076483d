/* What was measured, to the model of it. A model that did not compile on this host is missed once,
 * on the console, and its measurements are dropped. */
#include "bitcraze/adapter.h"

#include "bitcraze/conversions.h"

// clang-format off: each header only where its source is part of the library
#if CF_WITH_MM_TDOA
#include "mm_tdoa.h"
#endif
#define HAS_ROBUST_TDOA (CF_WITH_MM_TDOA_ROBUST && HAVE_ROBUST_TDOA)  // in its present form
#if HAS_ROBUST_TDOA
#include "mm_tdoa_robust.h"
#endif
#if CF_WITH_MM_POSITION
#include "mm_position.h"
#endif
#if CF_WITH_MM_POSE
#include "mm_pose.h"
#endif
#if CF_WITH_MM_DISTANCE
#include "mm_distance.h"
#endif
#if CF_WITH_MM_DISTANCE_ROBUST
#include "mm_distance_robust.h"
#endif
#if CF_WITH_MM_TOF
#include "mm_tof.h"
#endif
#if CF_WITH_MM_ABSOLUTE_HEIGHT
#include "mm_absolute_height.h"
#endif
#if CF_WITH_MM_FLOW
#include "mm_flow.h"
#endif
#if CF_WITH_MM_YAW_ERROR
#include "mm_yaw_error.h"
#endif
#define HAS_SWEEPS (CF_WITH_MM_SWEEP_ANGLES && CF_WITH_OUTLIERFILTERLIGHTHOUSE)
#if HAS_SWEEPS
#include "mm_sweep_angles.h"
#include "outlierFilterLighthouse.h"
#endif
// clang-format on

// what the estimator's task keeps for the models
static OutlierFilterTdoaState_t tdoa_filter;
#if HAS_SWEEPS
static OutlierFilterLhState_t sweep_filter;
#endif

static kalmanCoreData_t *const CORE CF_UNUSED = &cf_kalman_task.core;

#define MISSED(what_) \
  CF_SAY_ONCE("ESTKALMAN: no model of " what_ " in this build, measurements ignored\n")

#if HAS_SWEEPS
// Older filters know until when a window is open, and not how wide it is.
static void tell_sweep_window(void) {
#if HAVE_LIGHTHOUSE_OPENING_WINDOW
  cf_kalman_task.sweep_window = sweep_filter.openingWindowMs;
#endif
}
#endif

void cf_measurements_reset(void) {
  outlierFilterTdoaReset(&tdoa_filter);
#if HAS_SWEEPS
  outlierFilterLighthouseReset(&sweep_filter, 0);
  tell_sweep_window();
#endif
}

static void fuse_tdoa(const api_tdoaMeasurement_t *from, uint32_t now_ms CF_UNUSED) {
  tdoaMeasurement_t tdoa CF_UNUSED = cf_checkout_tdoa(from);
#if HAS_ROBUST_TDOA
  if (cf_kalman_task.robust_tdoa) {
    kalmanCoreRobustUpdateWithTdoa(CORE, &tdoa, &tdoa_filter);
    return;
  }
#endif
#if CF_WITH_MM_TDOA
  kalmanCoreUpdateWithTdoa(CORE, &tdoa, now_ms, &tdoa_filter);
#else
  MISSED("distance differences");
#endif
}

static void fuse_position(const api_positionMeasurement_t *from) {
  positionMeasurement_t position CF_UNUSED = cf_checkout_position(from);
#if CF_WITH_MM_POSITION
  kalmanCoreUpdateWithPosition(CORE, &position);
#else
  MISSED("positions");
#endif
}

static void fuse_pose(const api_poseMeasurement_t *from) {
  poseMeasurement_t pose CF_UNUSED = cf_checkout_pose(from);
#if CF_WITH_MM_POSE
  kalmanCoreUpdateWithPose(CORE, &pose);
#else
  MISSED("poses");
#endif
}

static void fuse_distance(const api_distanceMeasurement_t *from) {
  distanceMeasurement_t distance CF_UNUSED = cf_checkout_distance(from);
#if CF_WITH_MM_DISTANCE_ROBUST
  if (cf_kalman_task.robust_twr) {
    kalmanCoreRobustUpdateWithDistance(CORE, &distance);
    return;
  }
#endif
#if CF_WITH_MM_DISTANCE
  kalmanCoreUpdateWithDistance(CORE, &distance);
#else
  MISSED("distances");
#endif
}

static void fuse_tof(const api_tofMeasurement_t *from) {
  tofMeasurement_t tof CF_UNUSED = cf_checkout_tof(from);
#if CF_WITH_MM_TOF
  kalmanCoreUpdateWithTof(CORE, &tof);
#else
  MISSED("ranges to the floor");
#endif
}

static void fuse_height(const api_heightMeasurement_t *from) {
  heightMeasurement_t height CF_UNUSED = cf_checkout_height(from);
#if CF_WITH_MM_ABSOLUTE_HEIGHT
  kalmanCoreUpdateWithAbsoluteHeight(CORE, &height);
#else
  MISSED("heights");
#endif
}

static void fuse_flow(const api_flowMeasurement_t *from, const api_Axis3f *gyro_latest) {
  flowMeasurement_t flow CF_UNUSED = cf_checkout_flow(from);
  Axis3f turning         CF_UNUSED = cf_checkout_axes(gyro_latest);
#if CF_WITH_MM_FLOW
  kalmanCoreUpdateWithFlow(CORE, &flow, &turning);
#else
  MISSED("optical flow");
#endif
}

static void fuse_yaw_error(const api_yawErrorMeasurement_t *from) {
  yawErrorMeasurement_t error CF_UNUSED = cf_checkout_yaw_error(from);
#if CF_WITH_MM_YAW_ERROR
  kalmanCoreUpdateWithYawError(CORE, &error);
#else
  MISSED("yaw errors");
#endif
}

#if HAS_SWEEPS
static void fuse_sweep(const api_sweepAngleMeasurement_t *from, uint32_t now_ms) {
  lighthouseCalibrationSweep_t calibration;
  sweepAngleMeasurement_t      sweep = cf_checkout_sweep(from, &calibration);
  // lighthouse code that has geometry and calibration of the base station fills the pointers;
  // without them the filter cannot predict the angle
  if (sweep.sensorPos && sweep.rotorPos && sweep.rotorRot && sweep.rotorRotInv && sweep.calib &&
      sweep.calibrationMeasurementModel) {
    kalmanCoreUpdateWithSweepAngles(CORE, &sweep, now_ms, &sweep_filter);
    tell_sweep_window();
  }
}
#else
static void fuse_sweep(const api_sweepAngleMeasurement_t *from CF_UNUSED,
                       uint32_t now_ms                         CF_UNUSED) {
  MISSED("sweep angles");
}
#endif

void cf_measurements_fuse(void *state CF_UNUSED, const api_measurement_t *measurement,
                          const api_Axis3f *gyro_latest, uint32_t now_ms) {
  switch (measurement->type) {
    case api_MeasurementTypeTDOA:
      fuse_tdoa(&measurement->data.tdoa, now_ms);
      break;
    case api_MeasurementTypePosition:
      fuse_position(&measurement->data.position);
      break;
    case api_MeasurementTypePose:
      fuse_pose(&measurement->data.pose);
      break;
    case api_MeasurementTypeDistance:
      fuse_distance(&measurement->data.distance);
      break;
    case api_MeasurementTypeTOF:
      fuse_tof(&measurement->data.tof);
      break;
    case api_MeasurementTypeAbsoluteHeight:
      fuse_height(&measurement->data.height);
      break;
    case api_MeasurementTypeFlow:
      fuse_flow(&measurement->data.flow, gyro_latest);
      break;
    case api_MeasurementTypeYawError:
      fuse_yaw_error(&measurement->data.yawError);
      break;
    case api_MeasurementTypeSweepAngle:
      fuse_sweep(&measurement->data.sweepAngle, now_ms);
      break;
    default:
      // inertial samples belong to the task, and the barometer is not fused unless a build asks
      break;
  }
}
