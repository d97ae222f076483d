#include "bitcraze/rtos/hardware.h"

#include <stdbool.h>
#include <stddef.h>
#include <string.h>

// A checkout's own definition wins. Types that belong to a checkout stand here as pointers to
// anything, which for the linker is the same, and narrow integers as int, as they are passed.
#define WEAK __attribute__((weak))

uint16_t cf_hardware_motors[CF_HARDWARE_MOTORS];
float    cf_hardware_battery = 4.2f;

static bool is_armed;

// ------------------------------------------------------------------------------------------ motors

#define SETTINGS_BYTES 64

static const uint64_t NO_SETTINGS[SETTINGS_BYTES / sizeof(uint64_t)];

WEAK const uint16_t testsound[CF_HARDWARE_MOTORS];

void  motorsInit(const void *map);
bool  motorsTest(void);
void  motorsSetRatio(uint32_t id, uint16_t ratio);
int   motorsGetRatio(uint32_t id);
int   motorsGetRPM(uint32_t id);
void  motorsStop(void);
void  motorsResetESCs(void);
void  motorsBurstDshot(void);
void  motorsBeep(int id, bool enable, uint16_t frequency, uint16_t ratio);
void *motorsGetHealthTestSettings(uint32_t id);

WEAK void motorsInit(const void *map) {
  (void)map;
  motorsStop();
}

WEAK bool motorsTest(void) {
  return true;
}

WEAK void motorsSetRatio(uint32_t id, uint16_t ratio) {
  if (id < CF_HARDWARE_MOTORS) {
    cf_hardware_motors[id] = ratio;
  }
}

WEAK int motorsGetRatio(uint32_t id) {
  return id < CF_HARDWARE_MOTORS ? cf_hardware_motors[id] : 0;
}

WEAK int motorsGetRPM(uint32_t id) {
  (void)id;
  return 0;
}

WEAK void motorsStop(void) {
  memset(cf_hardware_motors, 0, sizeof cf_hardware_motors);
}

WEAK void motorsResetESCs(void) {
}

WEAK void motorsBurstDshot(void) {
}

WEAK void motorsBeep(int id, bool enable, uint16_t frequency, uint16_t ratio) {
  (void)id;
  (void)enable;
  (void)frequency;
  (void)ratio;
}

WEAK void *motorsGetHealthTestSettings(uint32_t id) {
  (void)id;
  return (void *)(uintptr_t)NO_SETTINGS;
}

// ------------------------------------------------------------------------------------------- power

float pmGetBatteryVoltage(void);
bool  pmIsChargerConnected(void);

WEAK float pmGetBatteryVoltage(void) {
  return cf_hardware_battery;
}

WEAK bool pmIsChargerConnected(void) {
  return false;
}

// -------------------------------------------------------------------------------- the rest of it

void       *platformConfigGetMotorMapping(void);
const char *platformConfigGetDeviceTypeName(void);
bool        isSensorsSuspended(void);
void        systemWaitStart(void);
bool        systemIsArmed(void);
void        systemSetArmed(bool value);
bool        deckGetRequiredKalmanEstimatorAttitudeReversionOff(void);
bool        locSrvIsEmergencyStopRequested(void);
uint32_t    locSrvGetEmergencyStopWatchdogNotificationTick(void);
void        eventTrigger(const void *event);
bool        ledseqRun(const void *sequence);
bool        ledseqStop(const void *sequence);
void        soundSetEffect(uint32_t effect);
void        soundSetFreq(uint32_t frequency);

WEAK void *platformConfigGetMotorMapping(void) {
  return NULL;
}

WEAK const char *platformConfigGetDeviceTypeName(void) {
  return "simulation";
}

WEAK bool isSensorsSuspended(void) {
  return false;
}

WEAK void systemWaitStart(void) {
}

WEAK bool systemIsArmed(void) {
  return is_armed;
}

WEAK void systemSetArmed(bool value) {
  is_armed = value;
}

WEAK bool deckGetRequiredKalmanEstimatorAttitudeReversionOff(void) {
  return false;
}

WEAK bool locSrvIsEmergencyStopRequested(void) {
  return false;
}

WEAK uint32_t locSrvGetEmergencyStopWatchdogNotificationTick(void) {
  return 0;
}

WEAK void eventTrigger(const void *event) {
  (void)event;
}

WEAK bool ledseqRun(const void *sequence) {
  (void)sequence;
  return true;
}

WEAK bool ledseqStop(const void *sequence) {
  (void)sequence;
  return true;
}

WEAK void soundSetEffect(uint32_t effect) {
  (void)effect;
}

WEAK void soundSetFreq(uint32_t frequency) {
  (void)frequency;
}
