/* Several ticks of the whole swarm without MuJoCo, as long as nothing can touch anything.
 *
 * Each flock of drones goes through all ticks of a window while its state is in the cache. The
 * integrator is that of single steps (free_flight.h), so that not a bit depends on which way was
 * taken: windows are no mode and have no state. A bound on gaps says beforehand that nothing will
 * touch; a drone that moves farther than it allows, or that wakes, takes the window back. Internal
 * to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_WINDOWS_H
#define CF_MUJOCO_PLUGIN_WINDOWS_H

#include "mujoco_plugin/downwash.h"
#include "mujoco_plugin/swarm.h"

#define CF_MOST_WINDOW_TICKS CF_DOWNWASH_PERIOD

// Whether a window may ever be possible in this model: drones over a flat floor, and nothing else.
void cf_windows_new(swarm_t *swarm, const mjModel *model);
void cf_windows_free(swarm_t *swarm);

// Advances by at most so many ticks. Returns by how many; or, where a window is not possible, minus
// the number of steps after which it is worth to ask again. After all of them, what mj_kinematics,
// mj_comPos and mj_camlight make is that of the last step; after less, a step is to follow.
int cf_windows_run(swarm_t *swarm, const mjModel *model, mjData *data, int ticks);

#endif  // CF_MUJOCO_PLUGIN_WINDOWS_H
