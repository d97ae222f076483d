#ifndef __MOTORS_H__
#define __MOTORS_H__

#include <stdbool.h>
#include <stdint.h>

#include "FreeRTOS.h"
#include "autoconf.h"
#include "config.h"
#include "stm32fxxx.h"
#include "task.h"

#define NBR_OF_MOTORS 4
#define MOTOR_M1 0
#define MOTOR_M2 1
#define MOTOR_M3 2
#define MOTOR_M4 3

// registers of the processor: unknown on a host, and only named
#define MOTORS_GPIO_TIM_PERIF RCC_APB1Periph_TIM2
#define MOTORS_TIM_BEEP_CLK_FREQ (84000000L / 2)

#define MOTORS_RPM_INVALID 65535

// notes [Hz]
#define C4 262
#define E4 330
#define G4 392
#define A4 440
#define OFF 0

typedef enum {
  BRUSHED,
  BRUSHLESS,
} motorsDrvType;

// What a motor does while its propeller is tested.
typedef struct {
  uint16_t onPeriodMsec;
  uint16_t offPeriodMsec;
  uint16_t varianceMeasurementStartMsec;
  uint16_t onPeriodPWMRatioProp;
  uint16_t onPeriodPWMRatioBat;
} MotorHealthTestDef;

typedef struct {
  motorsDrvType drvType;
  uint32_t      gpioPerif;
  GPIO_TypeDef *gpioPort;
  uint16_t      gpioPin;
  TIM_TypeDef  *tim;
  uint16_t      timPeriod;
  uint16_t      timPrescaler;
  void (*setCompare)(TIM_TypeDef *TIMx, uint32_t Compare);
  uint32_t (*getCompare)(TIM_TypeDef *TIMx);
  void (*ocInit)(TIM_TypeDef *TIMx, TIM_OCInitTypeDef *TIM_OCInitStruct);
} MotorPerifDef;

extern const MotorPerifDef *motorMapDefaultBrushed[NBR_OF_MOTORS];
extern const uint16_t       testsound[NBR_OF_MOTORS];

void motorsInit(const MotorPerifDef **motorMapSelect);
void motorsDeInit(const MotorPerifDef **motorMapSelect);
bool motorsTest(void);

void motorsSetRatio(uint32_t id, uint16_t ratio);
#if MINIATURE_RELEASE >= 202608
uint16_t motorsGetRatio(uint32_t id);
#else
int motorsGetRatio(uint32_t id);
#endif
void  motorsStop(void);
void  motorsResetESCs(void);
void  motorsBurstDshot(void);
float motorsCompensateBatteryVoltage(uint32_t id, float iThrust, float supplyVoltage);
void  motorsBeep(int id, bool enable, uint16_t frequency, uint16_t ratio);
#if MINIATURE_RELEASE >= 202608
uint16_t motorsGetRPM(uint32_t id);
#endif

const MotorHealthTestDef *motorsGetHealthTestSettings(uint32_t id);

#endif  // __MOTORS_H__
