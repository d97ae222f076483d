/* Parameters and log variables that clients look for and nothing on board computes with: identity,
 * lights, sound, decks that are not fitted, self-tests, radio statistics
 * (docs/reference/crtp-cflib.md#20).
 *
 * Lights, sound and decks keep what is written to them; nothing shines, sounds or is recorded in
 * the simulation. The types of names that that page marks as not read again are guesses. */
#ifndef CF_ONBOARD_SYSTEM_VARIABLES_H
#define CF_ONBOARD_SYSTEM_VARIABLES_H

#include <stdint.h>

#include "variables.h"

// A color LED deck.
typedef struct {
  uint32_t color;       // 0xWWRRGGBB, wrgb8888
  uint8_t  corrects;    // brightCorr
  uint8_t  throttling;  // [%], throttlePct, read-only: nothing gets hot here
} cf_color_led_t;

// An active marker deck: which number each of its lights blinks.
typedef struct {
  uint8_t front, right, back, left;
  uint8_t mode;
  uint8_t poll;
} cf_active_marker_t;

// A micro SD card deck, without a card.
typedef struct {
  uint8_t can_log;  // canLog, read-only: 0
  uint8_t logging;
  float   spi_written, spi_read, fat_written;  // [byte/s]
} cf_sd_card_t;

typedef struct {
  // what this drone is
  int8_t   selftest_passed;  // system.selftestPassed
  uint32_t revision0;        // firmware.revision0, 0: no revision of the firmware flies here
  uint16_t revision1;
  uint8_t  modified;
  uint16_t flash;  // [KiB], cpu.flash
  uint32_t id[3];  // cpu.id0, id1, id2: differ between drones

  // requests, which clear themselves
  uint8_t task_dump;
  uint8_t storage_stats;
  uint8_t assert_info;
  uint8_t memory_test_reset;  // memTst.resetW

  // lights and sound
  uint8_t  led_bitmask;
  uint8_t  ring_effect;
  uint8_t  ring_effects;  // ring.neffect, read-only
  uint8_t  ring_red, ring_green, ring_blue;
  uint8_t  ring_headlight;
  uint32_t ring_fade_color;  // 0xRRGGBB
  float    ring_fade_time;   // [s]
  uint8_t  sound_effect;
  uint32_t led_deck_color;  // 0xRRGGBB, led_deck_ctrl.rgb888

  cf_color_led_t color_led_bottom;  // colorLedBot
  cf_color_led_t color_led_top;     // colorLedTop

  cf_active_marker_t active_marker;
  cf_sd_card_t       sd_card;  // usd

  // statistics of the link; the simulated radio writes them
  uint8_t  radio_rssi;
  uint8_t  radio_is_connected;
  uint16_t radio_received_broadcasts;
  uint16_t radio_received_unicasts;
  uint16_t crtp_receive_rate;   // [packets/s]
  uint16_t crtp_transmit_rate;  // [packets/s]
  uint32_t memory_test_errors;  // memTst.errCntW
} cf_system_variables_t;

// `serial` tells the drones of a world apart.
void cf_system_variables_init(cf_system_variables_t *system, uint32_t seed, uint32_t serial);

// Serves the requests; 25 times a second.
void cf_system_variables_update(cf_system_variables_t *system);

cf_variables_t cf_system_variables_parameters(void);
cf_variables_t cf_system_variables_logs(void);

#endif  // CF_ONBOARD_SYSTEM_VARIABLES_H
