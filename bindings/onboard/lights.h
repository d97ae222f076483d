/* What clients have written for the LED ring: its colors, and a show of colors by time. Both are
 * kept as they were written. Nothing on board reads them; a renderer of the drone may
 * (docs/reference/crtp-cflib.md#10.3). */
#ifndef CF_ONBOARD_LIGHTS_H
#define CF_ONBOARD_LIGHTS_H

#include <stdint.h>

#define CF_LED_RING_BYTES 24      // RGB565 of 12 LEDs, high byte first
#define CF_LED_TIMINGS_BYTES 480  // entries of 4 bytes, ended by one of zeros

typedef struct {
  uint8_t ring[CF_LED_RING_BYTES];
  uint8_t timings[CF_LED_TIMINGS_BYTES];
} cf_lights_t;

#endif  // CF_ONBOARD_LIGHTS_H
