#include "onboard/power_management.h"

#include "variable_row.h"

#define LOW_DURATION 5000  // [ms]
#define CRITICAL_LOW 3.0f  // [V]
#define LEVELS 10

// open-circuit voltage [V] above which a cell still holds 10, 20, … 100 %
static const float LEVEL_VOLTAGE[LEVELS] = {3.62f, 3.70f, 3.74f, 3.77f, 3.80f,
                                            3.84f, 3.90f, 3.98f, 4.08f, 4.20f};

void cf_power_management_init(cf_power_management_t *power, cf_platform_t platform) {
  *power = (cf_power_management_t){
      .low_voltage          = cf_platform_facts(platform)->battery_low,
      .critical_low_voltage = CRITICAL_LOW,
      .state                = CF_POWER_BATTERY,
  };
}

void cf_power_management_measure(cf_power_management_t *power, float voltage) {
  power->voltage   = voltage;
  power->millivolt = (uint16_t)(voltage * 1000.0f);
}

static uint8_t level_of(float voltage) {
  int level = 0;
  while (level < LEVELS && voltage >= LEVEL_VOLTAGE[level]) {
    level++;
  }
  return (uint8_t)(10 * level);
}

void cf_power_management_update(cf_power_management_t *power, uint32_t tick) {
  if (power->voltage > power->low_voltage) {
    power->last_good_tick = tick;
  }
  const bool is_low = tick - power->last_good_tick > LOW_DURATION;
  power->state      = is_low ? CF_POWER_LOW : CF_POWER_BATTERY;
  power->level      = level_of(power->voltage);
}

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("pm", "lowVoltage", FLOAT, CF_PERSISTENT, cf_power_management_t, low_voltage),
    CF_ROW("pm", "criticalLowVoltage", FLOAT, CF_PERSISTENT, cf_power_management_t,
           critical_low_voltage),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("pm", "vbat", FLOAT, CF_CORE, cf_power_management_t, voltage),
    CF_ROW("pm", "vbatMV", UINT16, CF_CORE, cf_power_management_t, millivolt),
    CF_ROW("pm", "state", INT8, CF_CORE, cf_power_management_t, state),
    CF_ROW("pm", "batteryLevel", UINT8, CF_CORE, cf_power_management_t, level),
};

cf_variables_t cf_power_management_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_power_management_logs(void) {
  return CF_TABLE(LOGS);
}
