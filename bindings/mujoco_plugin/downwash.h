/* What drones feel of their surroundings: the wash of drones above, and how high they are above the
 * surface. Internal to the plugin.
 *
 * Every 5 ms all drones with running rotors are sorted into a grid, from the motion that the ticks
 * start with and before any drone ticks, so that neither threads nor their number change a bit.
 * Each drone then keeps what it feels in its own state. */
#ifndef CF_MUJOCO_PLUGIN_DOWNWASH_H
#define CF_MUJOCO_PLUGIN_DOWNWASH_H

#include "mujoco_plugin/swarm.h"

#define CF_DOWNWASH_PERIOD 5  // [ticks]

// Makes room for all drones of a swarm whose attributes have been read. Returns false when there is
// no memory.
bool cf_downwash_new(swarm_t *swarm);
void cf_downwash_free(swarm_t *swarm);

// Whether one of the ticks (before, now] starts with a look around.
bool cf_downwash_is_due(double before, double now);

// Takes the positions and thrusts of all drones out of work[].motion and their states.
void cf_downwash_look(swarm_t *swarm);

// Tells drone i what it feels. Several threads may tell several drones.
void cf_downwash_tell(const swarm_t *swarm, int i);

#endif  // CF_MUJOCO_PLUGIN_DOWNWASH_H
