// The task of the Kalman filter: one loop whenever the stabilizer asks for an estimate.
#define DEBUG_MODULE "ESTKALMAN"

// clang-format off
#include "kalman_core.h"
#include "kalman_supervisor.h"

#include "FreeRTOS.h"
#include "queue.h"
#include "task.h"
#include "semphr.h"
#include "sensors.h"
#include "static_mem.h"

#include "estimator.h"
#include "estimator_kalman.h"
#include "system.h"
#include "log.h"
#include "param.h"
#include "physicalConstants.h"
#include "supervisor.h"
#include "axis3fSubSampler.h"
#include "deck.h"

#include "statsCnt.h"
#include "rateSupervisor.h"

#include "mm_distance.h"
#include "mm_absolute_height.h"
#include "mm_position.h"
#include "mm_pose.h"
#include "mm_tdoa.h"
#include "mm_flow.h"
#include "mm_tof.h"
#include "mm_yaw_error.h"
#include "mm_sweep_angles.h"
#include "mm_tdoa_robust.h"
#include "mm_distance_robust.h"
#if MINIATURE_RELEASE >= 202512
#include "kalman_core_params_defaults.h"
#endif

#include "debug.h"
#include "cfassert.h"
// clang-format on

#define PREDICT_RATE RATE_100_HZ
#define PREDICTION_UPDATE_INTERVAL_MS (1000 / PREDICT_RATE)
#define WARNING_HOLD_BACK_TIME_MS 2000
#define ONE_SECOND 1000

static SemaphoreHandle_t runTaskSemaphore;

// guards taskEstimatorState and coreData
static SemaphoreHandle_t dataMutex;
static StaticSemaphore_t dataMutexBuffer;

static bool   isInit = false;
static Axis3f accLatest;   // [g]
static Axis3f gyroLatest;  // [deg/s]

static Axis3fSubSampler_t accSubSampler;
static Axis3fSubSampler_t gyroSubSampler;

static OutlierFilterTdoaState_t outlierFilterTdoaState;
static OutlierFilterLhState_t   sweepOutlierFilterState;

static rateSupervisor_t rateSupervisorContext;
static uint32_t         warningBlockTimeMs;

NO_DMA_CCM_SAFE_ZERO_INIT static kalmanCoreData_t coreData;

#if MINIATURE_RELEASE >= 202512
static kalmanCoreParams_t coreParams = {KALMAN_CORE_DEFAULT_PARAMS_INIT};
#else
static kalmanCoreParams_t coreParams;
#endif

static state_t taskEstimatorState;  // of the latest loop
static bool    resetEstimation = false;
static bool    robustTwr       = false;
static bool    robustTdoa      = false;

static STATS_CNT_RATE_DEFINE(updateCounter, ONE_SECOND);
static STATS_CNT_RATE_DEFINE(predictionCounter, ONE_SECOND);
static STATS_CNT_RATE_DEFINE(finalizeCounter, ONE_SECOND);

STATIC_MEM_TASK_ALLOC_STACK_NO_DMA_CCM_SAFE(kalmanTask, KALMAN_TASK_STACKSIZE);

static void kalmanTask(void *parameters);
static void updateQueuedMeasurements(const uint32_t nowMs, const bool quadIsFlying);

void estimatorKalmanTaskInit() {
#if MINIATURE_RELEASE >= 202512
#else
  kalmanCoreDefaultParams(&coreParams);
#endif
  runTaskSemaphore = xSemaphoreCreateBinary();
  ASSERT(runTaskSemaphore);
  dataMutex = xSemaphoreCreateMutexStatic(&dataMutexBuffer);
  STATIC_MEM_TASK_CREATE(kalmanTask, kalmanTask, KALMAN_TASK_NAME, NULL, KALMAN_TASK_PRI);
  isInit = true;
}

bool estimatorKalmanTaskTest() {
  return isInit;
}

static void kalmanTask(void *parameters) {
  (void)parameters;
  systemWaitStart();

  uint32_t nowMs            = T2M(xTaskGetTickCount());
  uint32_t nextPredictionMs = nowMs;

  rateSupervisorInit(&rateSupervisorContext, nowMs, ONE_SECOND, PREDICT_RATE - 1, PREDICT_RATE + 1,
                     1);

  while (true) {
    xSemaphoreTake(runTaskSemaphore, portMAX_DELAY);
    nowMs = T2M(xTaskGetTickCount());

    if (resetEstimation) {
      estimatorKalmanInit();
      resetEstimation = false;
    }

#ifdef CONFIG_ESTIMATOR_KALMAN_GENERAL_PURPOSE
    const bool quadIsFlying = false;
#else
    const bool quadIsFlying = supervisorIsFlying();
#endif

#ifdef KALMAN_DECOUPLE_XY
    kalmanCoreDecoupleXY(&coreData);
#endif

    // the averages hold what earlier loops took from the queue
    if (nowMs >= nextPredictionMs) {
      axis3fSubSamplerFinalize(&accSubSampler);
      axis3fSubSamplerFinalize(&gyroSubSampler);
#if MINIATURE_RELEASE >= 202512
      kalmanCorePredict(&coreData, &coreParams, &accSubSampler.subSample, &gyroSubSampler.subSample,
                        nowMs, quadIsFlying);
#else
      kalmanCorePredict(&coreData, &accSubSampler.subSample, &gyroSubSampler.subSample, nowMs,
                        quadIsFlying);
#endif
      nextPredictionMs = nowMs + PREDICTION_UPDATE_INTERVAL_MS;

      STATS_CNT_RATE_EVENT(&predictionCounter);
      if (!rateSupervisorValidate(&rateSupervisorContext, nowMs)) {
        DEBUG_PRINT("WARNING: Kalman prediction rate off (%lu)\n",
                    (unsigned long)rateSupervisorLatestCount(&rateSupervisorContext));
      }
    }

    kalmanCoreAddProcessNoise(&coreData, &coreParams, nowMs);
    updateQueuedMeasurements(nowMs, quadIsFlying);

    if (kalmanCoreFinalize(&coreData)) {
      STATS_CNT_RATE_EVENT(&finalizeCounter);
    }

    if (!kalmanSupervisorIsStateWithinBounds(&coreData)) {
      resetEstimation = true;
      if (nowMs > warningBlockTimeMs) {
        warningBlockTimeMs = nowMs + WARNING_HOLD_BACK_TIME_MS;
        DEBUG_PRINT("State out of bounds, resetting\n");
      }
    }

    xSemaphoreTake(dataMutex, portMAX_DELAY);
    kalmanCoreExternalizeState(&coreData, &taskEstimatorState, &accLatest);
    xSemaphoreGive(dataMutex);

    STATS_CNT_RATE_EVENT(&updateCounter);
  }
}

void estimatorKalman(state_t *state, const stabilizerStep_t stabilizerStep) {
  (void)stabilizerStep;
  // what the task has found when it ran last
  xSemaphoreTake(dataMutex, portMAX_DELAY);
  memcpy(state, &taskEstimatorState, sizeof(state_t));
  xSemaphoreGive(dataMutex);

  xSemaphoreGive(runTaskSemaphore);
}

static void fuse(measurement_t *m, const uint32_t nowMs, const bool quadIsFlying) {
  switch (m->type) {
    case MeasurementTypeTDOA:
      if (robustTdoa) {
        kalmanCoreRobustUpdateWithTdoa(&coreData, &m->data.tdoa, &outlierFilterTdoaState);
      } else {
        kalmanCoreUpdateWithTdoa(&coreData, &m->data.tdoa, nowMs, &outlierFilterTdoaState);
      }
      break;
    case MeasurementTypePosition:
      kalmanCoreUpdateWithPosition(&coreData, &m->data.position);
      break;
    case MeasurementTypePose:
      kalmanCoreUpdateWithPose(&coreData, &m->data.pose);
      break;
    case MeasurementTypeDistance:
      if (robustTwr) {
        kalmanCoreRobustUpdateWithDistance(&coreData, &m->data.distance);
      } else {
        kalmanCoreUpdateWithDistance(&coreData, &m->data.distance);
      }
      break;
    case MeasurementTypeTOF:
      kalmanCoreUpdateWithTof(&coreData, &m->data.tof);
      break;
    case MeasurementTypeAbsoluteHeight:
      kalmanCoreUpdateWithAbsoluteHeight(&coreData, &m->data.height);
      break;
    case MeasurementTypeFlow:
      kalmanCoreUpdateWithFlow(&coreData, &m->data.flow, &gyroLatest);
      break;
    case MeasurementTypeYawError:
      kalmanCoreUpdateWithYawError(&coreData, &m->data.yawError);
      break;
    case MeasurementTypeSweepAngle:
      kalmanCoreUpdateWithSweepAngles(&coreData, &m->data.sweepAngle, nowMs,
                                      &sweepOutlierFilterState);
      break;
    case MeasurementTypeGyroscope:
      axis3fSubSamplerAccumulate(&gyroSubSampler, &m->data.gyroscope.gyro);
      gyroLatest = m->data.gyroscope.gyro;
      break;
    case MeasurementTypeAcceleration:
      axis3fSubSamplerAccumulate(&accSubSampler, &m->data.acceleration.acc);
      accLatest = m->data.acceleration.acc;
      break;
    case MeasurementTypeBarometer:
#ifdef CONFIG_ESTIMATOR_KALMAN_USE_BARO_UPDATE
      kalmanCoreUpdateWithBaro(&coreData, &coreParams, m->data.barometer.baro.asl, quadIsFlying);
#else
      (void)quadIsFlying;
#endif
      break;
    default:
      break;
  }
}

static void updateQueuedMeasurements(const uint32_t nowMs, const bool quadIsFlying) {
  measurement_t m;
  while (estimatorDequeue(&m)) {
    fuse(&m, nowMs, quadIsFlying);
  }
}

void estimatorKalmanInit(void) {
#if MINIATURE_RELEASE >= 202512
#ifdef CONFIG_DECK_LOCO_2D_POSITION
  coreParams.attitudeReversion = 0.0f;
#endif
  if (deckGetRequiredKalmanEstimatorAttitudeReversionOff()) {
    coreParams.attitudeReversion = 0.0f;
  }

#endif
  axis3fSubSamplerInit(&accSubSampler, GRAVITY_MAGNITUDE);
  axis3fSubSamplerInit(&gyroSubSampler, DEG_TO_RAD);

  outlierFilterTdoaReset(&outlierFilterTdoaState);
  outlierFilterLighthouseReset(&sweepOutlierFilterState, 0);

  const uint32_t nowMs = T2M(xTaskGetTickCount());
  kalmanCoreInit(&coreData, &coreParams, nowMs);
}

bool estimatorKalmanTest(void) {
  return isInit;
}

void estimatorKalmanGetEstimatedPos(point_t *pos) {
  pos->x = coreData.S[KC_STATE_X];
  pos->y = coreData.S[KC_STATE_Y];
  pos->z = coreData.S[KC_STATE_Z];
}

void estimatorKalmanGetEstimatedRot(float *rotationMatrix) {
  memcpy(rotationMatrix, coreData.R, 9 * sizeof(float));
}

LOG_GROUP_START(kalman)
LOG_ADD(LOG_FLOAT, stateX, &coreData.S[KC_STATE_X])
LOG_ADD(LOG_FLOAT, stateY, &coreData.S[KC_STATE_Y])
LOG_ADD(LOG_FLOAT, stateZ, &coreData.S[KC_STATE_Z])
LOG_ADD(LOG_FLOAT, statePX, &coreData.S[KC_STATE_PX])
LOG_ADD(LOG_FLOAT, statePY, &coreData.S[KC_STATE_PY])
LOG_ADD(LOG_FLOAT, statePZ, &coreData.S[KC_STATE_PZ])
LOG_ADD(LOG_FLOAT, stateD0, &coreData.S[KC_STATE_D0])
LOG_ADD(LOG_FLOAT, stateD1, &coreData.S[KC_STATE_D1])
LOG_ADD(LOG_FLOAT, stateD2, &coreData.S[KC_STATE_D2])
LOG_ADD(LOG_FLOAT, varX, &coreData.P[KC_STATE_X][KC_STATE_X])
LOG_ADD(LOG_FLOAT, varY, &coreData.P[KC_STATE_Y][KC_STATE_Y])
LOG_ADD(LOG_FLOAT, varZ, &coreData.P[KC_STATE_Z][KC_STATE_Z])
LOG_ADD(LOG_FLOAT, varPX, &coreData.P[KC_STATE_PX][KC_STATE_PX])
LOG_ADD(LOG_FLOAT, varPY, &coreData.P[KC_STATE_PY][KC_STATE_PY])
LOG_ADD(LOG_FLOAT, varPZ, &coreData.P[KC_STATE_PZ][KC_STATE_PZ])
LOG_ADD(LOG_FLOAT, varD0, &coreData.P[KC_STATE_D0][KC_STATE_D0])
LOG_ADD(LOG_FLOAT, varD1, &coreData.P[KC_STATE_D1][KC_STATE_D1])
LOG_ADD(LOG_FLOAT, varD2, &coreData.P[KC_STATE_D2][KC_STATE_D2])
LOG_ADD(LOG_FLOAT, q0, &coreData.q[0])
LOG_ADD(LOG_FLOAT, q1, &coreData.q[1])
LOG_ADD(LOG_FLOAT, q2, &coreData.q[2])
LOG_ADD(LOG_FLOAT, q3, &coreData.q[3])
STATS_CNT_RATE_LOG_ADD(rtUpdate, &updateCounter)
STATS_CNT_RATE_LOG_ADD(rtPred, &predictionCounter)
STATS_CNT_RATE_LOG_ADD(rtFinal, &finalizeCounter)
LOG_GROUP_STOP(kalman)

LOG_GROUP_START(outlierf)
#if MINIATURE_RELEASE >= 202502
LOG_ADD(LOG_INT32, lhWin, &sweepOutlierFilterState.openingWindowMs)
#else
LOG_ADD(LOG_INT32, lhWin, &sweepOutlierFilterState.validUntilMs)
#endif
LOG_GROUP_STOP(outlierf)

PARAM_GROUP_START(kalman)
PARAM_ADD_CORE(PARAM_UINT8, resetEstimation, &resetEstimation)
PARAM_ADD_CORE(PARAM_UINT8, robustTdoa, &robustTdoa)
PARAM_ADD_CORE(PARAM_UINT8, robustTwr, &robustTwr)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, pNAcc_xy, &coreParams.procNoiseAcc_xy)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, pNAcc_z, &coreParams.procNoiseAcc_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, pNVel, &coreParams.procNoiseVel)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, pNPos, &coreParams.procNoisePos)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, pNAtt, &coreParams.procNoiseAtt)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, mNBaro, &coreParams.measNoiseBaro)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, mNGyro_rollpitch,
               &coreParams.measNoiseGyro_rollpitch)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, mNGyro_yaw, &coreParams.measNoiseGyro_yaw)
PARAM_ADD_CORE(PARAM_FLOAT, initialX, &coreParams.initialX)
PARAM_ADD_CORE(PARAM_FLOAT, initialY, &coreParams.initialY)
PARAM_ADD_CORE(PARAM_FLOAT, initialZ, &coreParams.initialZ)
PARAM_ADD_CORE(PARAM_FLOAT, initialYaw, &coreParams.initialYaw)
#if MINIATURE_RELEASE >= 202608
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, dragB_x, &coreParams.dragB_x)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, dragB_y, &coreParams.dragB_y)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, dragB_z, &coreParams.dragB_z)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, cop_x, &coreParams.cop_x)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, cop_y, &coreParams.cop_y)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, cop_z, &coreParams.cop_z)
#endif
PARAM_GROUP_STOP(kalman)
