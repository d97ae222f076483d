/* Decks: the facts that their drivers and the plant must agree on, and what passes between them.
 *
 * Source: docs/reference/estimators.md#13.1, #13.2, #13.4 and #13.5. */
#ifndef CF_DECK_FACTS_H
#define CF_DECK_FACTS_H

#include <stdint.h>

#include "api/lighthouse_types.h"

// ----------------------------------------------------------------------------------------- ranges

// Where a distance may point, in the order of the log.
typedef enum {
  CF_RANGE_FRONT = 0,
  CF_RANGE_BACK  = 1,
  CF_RANGE_UP    = 2,
  CF_RANGE_LEFT  = 3,
  CF_RANGE_RIGHT = 4,
  CF_RANGE_DOWN  = 5,
  CF_RANGE_COUNT = 6,
} cf_range_direction_t;

// -------------------------------------------------------------------------------------- flow deck

#define CF_FLOW_DECK_RANGE 1  // a range was measured at this tick
#define CF_FLOW_DECK_FLOW 2   // flow was measured at this tick

#define CF_FLOW_MOTION 176     // motion register: pixels were counted
#define CF_FLOW_NO_MOTION 48   // nothing could be seen
#define CF_RANGE_NOTHING 8190  // [mm], reading of a range that meets nothing

// The registers of PMW3901 and VL53L1x.
typedef struct {
  uint16_t range;    // [mm]
  int16_t  delta_x;  // [counts], along the axes of the chip
  int16_t  delta_y;  // [counts]
  uint16_t shutter;  // brightness of the floor, as exposure time
  uint8_t  motion;   // CF_FLOW_MOTION or not
  uint8_t  squal;    // surface quality
} cf_flow_reading_t;

// Pure: standard deviation [m] of a range [m].
float cf_range_std(float distance);

// -------------------------------------------------------------------------------- lighthouse deck

#define CF_LIGHTHOUSE_STATIONS 2
#define CF_LIGHTHOUSE_SENSORS 4
#define CF_LIGHTHOUSE_SWEEPS 2

// One light plane of one base station has passed over the deck.
typedef struct {
  uint8_t station;                        // 0 or 1
  uint8_t sweep;                          // 0 or 1, which of its two planes
  uint8_t sensors;                        // bit i: sensor i was hit
  float   angles[CF_LIGHTHOUSE_SENSORS];  // [rad], of the sensors that were hit
} cf_sweep_t;

// Pure: where a sensor sits [m, body], or null unless 0 <= sensor < CF_LIGHTHOUSE_SENSORS.
const vec3d *cf_lighthouse_sensor_position(int sensor);

// Pure: tilt [rad] of light plane 0 or 1 of a base station of the second generation.
float cf_lighthouse_tilt(int sweep);

// Pure: rotation, base station to world, of one that stands upright at a position and looks at a
// target [m, world]: x to the front, y left, z up. At a target straight above or below it, y is
// that of the world.
void cf_lighthouse_look_at(const float position[3], const float target[3], mat3d rotation);

// -------------------------------------------------------------------------------------- loco deck

#define CF_LOCO_ANCHORS 8

// Values of the parameter loco.mode.
typedef enum {
  CF_LOCO_AUTO  = 0,
  CF_LOCO_TWR   = 1,
  CF_LOCO_TDOA2 = 2,
  CF_LOCO_TDOA3 = 3,
} cf_loco_mode_t;

typedef struct {
  uint8_t mode;      // cf_loco_mode_t, never CF_LOCO_AUTO
  uint8_t anchor;    // id of the anchor whose packet arrived
  uint8_t previous;  // TDoA: the one that it is compared with
  float   distance;  // [m], to `anchor`; TDoA: the same minus the distance to `previous`
} cf_ranging_t;

#endif  // CF_DECK_FACTS_H
