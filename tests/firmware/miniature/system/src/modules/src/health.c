// Spins each motor briefly and listens to its propeller, or all of them and looks at the battery.
#define DEBUG_MODULE "HEALTH"

// clang-format off
#include "config.h"
#include "log.h"
#include "param.h"
#include "debug.h"
#include "motors.h"
#include "sensors.h"
#include "pm.h"
#include "supervisor.h"
#include "autoconf.h"
#include "static_mem.h"
#include "platform_defaults.h"
// clang-format on

#ifndef HEALTH_PROPELLER_TEST_THRESHOLD
#define HEALTH_PROPELLER_TEST_THRESHOLD 0.0f  // [g^2], 0: every propeller passes
#endif
#ifndef HEALTH_BATTERY_SAG_THRESHOLD
#define HEALTH_BATTERY_SAG_THRESHOLD 0.95f  // [V]
#endif

typedef enum {
  configureAcc,
  measureProp,
  testBattery,
  testDone,
} TestState;

static TestState testState = testDone;

static uint8_t startPropTest;
static uint8_t startBatTest;

// of the running test
static uint8_t  motorToTest;
static uint32_t testTime;  // [ms], since its motors started
static uint32_t nrOfSamples;
static float    sumX, sumY;
static float    sumSquareX, sumSquareY;
static float    idleVoltage;
static float    minLoadedVoltage;

// results
static float    accVarX[NBR_OF_MOTORS];  // [g^2]
static float    accVarY[NBR_OF_MOTORS];
static uint8_t  motorPass;  // bit per motor
static uint16_t motorTestCount;
static float    batterySag;
static uint8_t  batteryPass;

static void startMotor(uint8_t motor) {
  motorToTest = motor;
  testTime    = 0;
  nrOfSamples = 0;
  sumX        = 0;
  sumY        = 0;
  sumSquareX  = 0;
  sumSquareY  = 0;
}

bool healthShallWeRunTest(void) {
  if (testState != testDone) {
    return true;
  }
  if (!startPropTest && !startBatTest) {
    return false;
  }
  // no test in flight
  if (!supervisorIsFlying()) {
    testState = startPropTest ? configureAcc : testBattery;
    startMotor(0);
  }
  startPropTest = 0;
  startBatTest  = 0;
  return testState != testDone;
}

static float variance(float sum, float sumSquare, uint32_t samples) {
  const float n    = (float)samples;
  const float mean = sum / n;
  return sumSquare / n - mean * mean;
}

static bool evaluatePropTest(uint8_t motor) {
  accVarX[motor]        = variance(sumX, sumSquareX, nrOfSamples);
  accVarY[motor]        = variance(sumY, sumSquareY, nrOfSamples);
  const float threshold = HEALTH_PROPELLER_TEST_THRESHOLD;
  return threshold == 0.0f || accVarX[motor] + accVarY[motor] < threshold;
}

// Of the settings of the motor, what the build does not replace.
static uint16_t ratioOr(uint16_t configured, uint16_t setting) {
  return configured != 0 ? configured : setting;
}

static void setAllMotors(uint16_t ratio) {
  for (int i = 0; i < NBR_OF_MOTORS; i++) {
    motorsSetRatio(i, ratio);
  }
}

static void finishMotor(void) {
  if (evaluatePropTest(motorToTest)) {
    motorPass |= (1 << motorToTest);
  } else {
    // tells which one by its tone
    motorsBeep(motorToTest, true, testsound[motorToTest],
               (uint16_t)(MOTORS_TIM_BEEP_CLK_FREQ / A4) / 20);
    vTaskDelay(M2T(500));
    motorsBeep(motorToTest, false, 0, 0);
  }

  if (motorToTest + 1 < NBR_OF_MOTORS) {
    startMotor(motorToTest + 1);
  } else {
    DEBUG_PRINT("Propeller test: passed 0x%x\n", motorPass);
    motorTestCount++;
    sensorsSetAccMode(ACC_MODE_FLIGHT);
    testState = testDone;
  }
}

static void runPropTest(const MotorHealthTestDef *settings, const sensorData_t *sensors) {
  if (testState == configureAcc) {
    motorPass = 0;
    sensorsSetAccMode(ACC_MODE_PROPTEST);
    testState = measureProp;
  }

  setAllMotors(0);
  if (testTime < settings->onPeriodMsec) {
    motorsSetRatio(motorToTest, ratioOr(CONFIG_MOTORS_DEFAULT_PROP_TEST_PWM_RATIO,
                                        settings->onPeriodPWMRatioProp));
    if (testTime >= settings->varianceMeasurementStartMsec) {
      sumX += sensors->acc.x;
      sumY += sensors->acc.y;
      sumSquareX += sensors->acc.x * sensors->acc.x;
      sumSquareY += sensors->acc.y * sensors->acc.y;
      nrOfSamples++;
    }
  }
  testTime++;
  if (testTime >= (uint32_t)settings->onPeriodMsec + settings->offPeriodMsec) {
    finishMotor();
  }
}

static void runBatTest(const MotorHealthTestDef *settings) {
  const float voltage = pmGetBatteryVoltage();

  setAllMotors(0);
  if (testTime == 0) {
    idleVoltage      = voltage;
    minLoadedVoltage = voltage;
  }
  if (voltage < minLoadedVoltage) {
    minLoadedVoltage = voltage;
  }
  if (testTime < settings->onPeriodMsec) {
    setAllMotors(ratioOr(CONFIG_MOTORS_DEFAULT_BAT_TEST_PWM_RATIO, settings->onPeriodPWMRatioBat));
  }
  testTime++;
  if (testTime >= (uint32_t)settings->onPeriodMsec + settings->offPeriodMsec) {
    batterySag  = idleVoltage - minLoadedVoltage;
    batteryPass = batterySag < HEALTH_BATTERY_SAG_THRESHOLD;
    DEBUG_PRINT("Battery test: %s\n", batteryPass ? "[OK]" : "[FAIL]");
    testState = testDone;
  }
}

void healthRunTests(sensorData_t *sensors) {
  const MotorHealthTestDef *settings = motorsGetHealthTestSettings(motorToTest);
  if (testState == testBattery) {
    runBatTest(settings);
  } else if (testState != testDone) {
    runPropTest(settings, sensors);
  }
}

PARAM_GROUP_START(health)
PARAM_ADD_CORE(PARAM_UINT8, startPropTest, &startPropTest)
PARAM_ADD_CORE(PARAM_UINT8, startBatTest, &startBatTest)
PARAM_GROUP_STOP(health)

LOG_GROUP_START(health)
LOG_ADD(LOG_FLOAT, motorVarXM1, &accVarX[0])
LOG_ADD(LOG_FLOAT, motorVarYM1, &accVarY[0])
LOG_ADD(LOG_FLOAT, motorVarXM2, &accVarX[1])
LOG_ADD(LOG_FLOAT, motorVarYM2, &accVarY[1])
LOG_ADD(LOG_FLOAT, motorVarXM3, &accVarX[2])
LOG_ADD(LOG_FLOAT, motorVarYM3, &accVarY[2])
LOG_ADD(LOG_FLOAT, motorVarXM4, &accVarX[3])
LOG_ADD(LOG_FLOAT, motorVarYM4, &accVarY[3])
LOG_ADD_CORE(LOG_UINT8, motorPass, &motorPass)
LOG_ADD(LOG_FLOAT, batterySag, &batterySag)
LOG_ADD_CORE(LOG_UINT8, batteryPass, &batteryPass)
LOG_ADD_CORE(LOG_UINT16, motorTestCount, &motorTestCount)
LOG_GROUP_STOP(health)
