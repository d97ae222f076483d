/* How good a motion-capture system is: three sets of numbers, from recorded flights.
 *
 * docs/mocap.md says what was measured and which number stands for what. */
#ifndef CF_VEHICLE_POSITIONING_MOCAP_QUALITY_H
#define CF_VEHICLE_POSITIONING_MOCAP_QUALITY_H

#include "status.h"
#include "vehicle/positioning/mocap.h"

typedef enum {
  CF_MOCAP_GOOD    = 0,  // every frame arrives, always as late
  CF_MOCAP_TYPICAL = 1,  // a shared radio, now and then a hidden marker
  CF_MOCAP_POOR    = 2,  // few cameras, a crowded room, a busy radio
  CF_MOCAP_QUALITY_COUNT,
} cf_mocap_quality_t;

// Writes the numbers of a quality, all of the config. Returns CF_ERR_UNKNOWN and leaves the config
// untouched when there is no such quality.
cf_status_t cf_mocap_of_quality(cf_mocap_config_t *config, cf_mocap_quality_t quality);

#endif  // CF_VEHICLE_POSITIONING_MOCAP_QUALITY_H
