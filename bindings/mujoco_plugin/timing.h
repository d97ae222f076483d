/* How long the parts of a step take. Off at first; never influences the simulation. Internal to the
 * plugin. */
#ifndef CF_MUJOCO_PLUGIN_TIMING_H
#define CF_MUJOCO_PLUGIN_TIMING_H

#include <stdint.h>

enum { TIME_ONBOARD = 0, TIME_VEHICLE = 1, TIME_PARTS = 2 };

// Returns now [ns], or 0 while timing is off.
uint64_t cf_timer_start(void);

// Adds the time since `start` to a part and returns now.
uint64_t cf_timer_add(int part, uint64_t start);

#endif  // CF_MUJOCO_PLUGIN_TIMING_H
