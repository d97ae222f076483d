/* The smallest engine plugin that keeps a body in the air: crazychoir.thrust, a constant force
 * along body z.
 *
 * Baseline of the benchmarks: what a world costs without onboard software and vehicle. */
#ifndef CF_MUJOCO_PLUGIN_THRUST_PLUGIN_H
#define CF_MUJOCO_PLUGIN_THRUST_PLUGIN_H

#include "mujoco_plugin/mujoco_api.h"

// Registers the plugin. Returns its slot, or -1.
int cf_thrust_plugin_register(const cf_mujoco_api_t *mj);

#endif  // CF_MUJOCO_PLUGIN_THRUST_PLUGIN_H
