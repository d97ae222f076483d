#include "onboard/system_variables.h"

#include "variable_row.h"

#define FLASH_KIB 1024
#define RING_EFFECTS 18
#define FADE_TIME 0.5f  // [s]

void cf_system_variables_init(cf_system_variables_t *system, uint32_t seed, uint32_t serial) {
  *system = (cf_system_variables_t){
      .selftest_passed = 1,
      .flash           = FLASH_KIB,
      .id              = {0x43465349, seed, serial},
      .ring_effects    = RING_EFFECTS,
      .ring_fade_time  = FADE_TIME,

      .color_led_bottom.corrects = 1,
      .color_led_top.corrects    = 1,

      .active_marker = {.front = 1, .right = 2, .back = 3, .left = 4},
  };
}

void cf_system_variables_update(cf_system_variables_t *system) {
  if (system->memory_test_reset != 0) {
    system->memory_test_errors = 0;
  }
  system->memory_test_reset = 0;
  system->task_dump         = 0;
  system->storage_stats     = 0;
  system->assert_info       = 0;
}

#define VARIABLE(group_, name_, type_, flags_, member_) \
  CF_ROW(group_, name_, type_, flags_, cf_system_variables_t, member_)

#define COLOR_LED(group_, member_)                                            \
  VARIABLE(group_, "wrgb8888", UINT32, 0, member_.color),                     \
      VARIABLE(group_, "brightCorr", UINT8, CF_PERSISTENT, member_.corrects), \
      VARIABLE(group_, "throttlePct", UINT8, CF_READ_ONLY, member_.throttling)

static const cf_variable_t PARAMETERS[] = {
    VARIABLE("system", "taskDump", UINT8, 0, task_dump),
    VARIABLE("system", "selftestPassed", INT8, CF_CORE | CF_READ_ONLY, selftest_passed),
    VARIABLE("system", "storageStats", UINT8, 0, storage_stats),
    VARIABLE("system", "assertInfo", UINT8, 0, assert_info),
    VARIABLE("firmware", "revision0", UINT32, CF_CORE | CF_READ_ONLY, revision0),
    VARIABLE("firmware", "revision1", UINT16, CF_CORE | CF_READ_ONLY, revision1),
    VARIABLE("firmware", "modified", UINT8, CF_CORE | CF_READ_ONLY, modified),
    VARIABLE("cpu", "flash", UINT16, CF_CORE | CF_READ_ONLY, flash),
    VARIABLE("cpu", "id0", UINT32, CF_CORE | CF_READ_ONLY, id[0]),
    VARIABLE("cpu", "id1", UINT32, CF_CORE | CF_READ_ONLY, id[1]),
    VARIABLE("cpu", "id2", UINT32, CF_CORE | CF_READ_ONLY, id[2]),
    VARIABLE("led", "bitmask", UINT8, CF_CORE, led_bitmask),
    VARIABLE("ring", "effect", UINT8, CF_CORE | CF_PERSISTENT, ring_effect),
    VARIABLE("ring", "neffect", UINT8, CF_CORE | CF_READ_ONLY, ring_effects),
    VARIABLE("ring", "solidRed", UINT8, CF_CORE | CF_PERSISTENT, ring_red),
    VARIABLE("ring", "solidGreen", UINT8, CF_CORE | CF_PERSISTENT, ring_green),
    VARIABLE("ring", "solidBlue", UINT8, CF_CORE | CF_PERSISTENT, ring_blue),
    VARIABLE("ring", "headlightEnable", UINT8, CF_CORE, ring_headlight),
    VARIABLE("ring", "fadeColor", UINT32, CF_CORE | CF_PERSISTENT, ring_fade_color),
    VARIABLE("ring", "fadeTime", FLOAT, CF_CORE | CF_PERSISTENT, ring_fade_time),
    VARIABLE("sound", "effect", UINT8, CF_CORE, sound_effect),
    VARIABLE("led_deck_ctrl", "rgb888", UINT32, 0, led_deck_color),
    COLOR_LED("colorLedBot", color_led_bottom),
    COLOR_LED("colorLedTop", color_led_top),
    VARIABLE("activeMarker", "front", UINT8, CF_PERSISTENT, active_marker.front),
    VARIABLE("activeMarker", "right", UINT8, CF_PERSISTENT, active_marker.right),
    VARIABLE("activeMarker", "back", UINT8, CF_PERSISTENT, active_marker.back),
    VARIABLE("activeMarker", "left", UINT8, CF_PERSISTENT, active_marker.left),
    VARIABLE("activeMarker", "mode", UINT8, CF_PERSISTENT, active_marker.mode),
    VARIABLE("activeMarker", "poll", UINT8, 0, active_marker.poll),
    VARIABLE("usd", "canLog", UINT8, CF_READ_ONLY, sd_card.can_log),
    VARIABLE("usd", "logging", UINT8, 0, sd_card.logging),
    VARIABLE("memTst", "resetW", UINT8, 0, memory_test_reset),
};

static const cf_variable_t LOGS[] = {
    VARIABLE("radio", "rssi", UINT8, CF_CORE, radio_rssi),
    VARIABLE("radio", "isConnected", UINT8, CF_CORE, radio_is_connected),
    VARIABLE("radio", "numRxBc", UINT16, 0, radio_received_broadcasts),
    VARIABLE("radio", "numRxUc", UINT16, 0, radio_received_unicasts),
    VARIABLE("crtp", "rxRate", UINT16, 0, crtp_receive_rate),
    VARIABLE("crtp", "txRate", UINT16, 0, crtp_transmit_rate),
    VARIABLE("usd", "spiWrBps", FLOAT, 0, sd_card.spi_written),
    VARIABLE("usd", "spiReBps", FLOAT, 0, sd_card.spi_read),
    VARIABLE("usd", "fatWrBps", FLOAT, 0, sd_card.fat_written),
    VARIABLE("memTst", "errCntW", UINT32, 0, memory_test_errors),
};

cf_variables_t cf_system_variables_parameters(void) {
  return CF_TABLE(PARAMETERS);
}

cf_variables_t cf_system_variables_logs(void) {
  return CF_TABLE(LOGS);
}
