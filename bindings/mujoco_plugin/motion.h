/* From a body in mjData to the motion that a drone senses. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_MOTION_H
#define CF_MUJOCO_PLUGIN_MOTION_H

#include "crazyflie.h"
#include "mujoco_plugin/swarm.h"

// The drone's struct within plugin_state.
cf_t *cf_state_of(const drone_t *drone, mjData *data);

// Pose and twist; specific force stays as it is.
void cf_motion_of(const drone_t *drone, const mjData *data, cf_motion_t *motion);

// Reads the complete motion after a step; `elapsed` [s] have gone by since the last time. Also puts
// the body to rest when its motion is no number (the returned motion still says so), and wakes it
// when it sleeps while its rotors push.
void cf_motion_sample(const drone_t *drone, const mjModel *model, mjData *data, double elapsed,
                      cf_motion_t *motion);

#endif  // CF_MUJOCO_PLUGIN_MOTION_H
