/* The generalized forces of rotors and air on one drone. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_FORCES_H
#define CF_MUJOCO_PLUGIN_FORCES_H

#include "mujoco_plugin/swarm.h"

// Force [N, world] and torque [N m, body] at the free joint, for this motion and these body rates
// [rad/s].
void cf_forces_of(const mjModel *model, const drone_t *drone, const cf_t *cf,
                  const cf_motion_t *motion, const double rates[3], double out[6]);

#endif  // CF_MUJOCO_PLUGIN_FORCES_H
