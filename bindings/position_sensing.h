/* Where vehicle and onboard software meet for positions: from the positioning system that is fitted
 * to the queue of the estimator. Internal to C. */
#ifndef CF_POSITION_SENSING_H
#define CF_POSITION_SENSING_H

#include "crazyflie.h"

// Tells the drivers of a drone that just booted what they are to know: decks, anchors, base
// stations.
void cf_position_boot(cf_t *cf);

// One millisecond of the positioning system.
void cf_position_sense(cf_t *cf, const cf_motion_t *motion);

#endif  // CF_POSITION_SENSING_H
