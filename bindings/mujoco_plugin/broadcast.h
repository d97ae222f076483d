/* What a motion-capture ground station tells each drone: where the others are. Internal to the
 * plugin.
 *
 * It sees every drone of the model, and tells those that avoid collisions (colAv.enable) of their
 * nearest neighbors, as many as fit into their tables. Positions are true ones, of this instant:
 * neither the noise of the cameras nor the latency of the radio is added, which are small beside
 * the margins that drones keep. A drone that the cameras have lost is not told of, and its last
 * position grows old in the tables of the others. */
#ifndef CF_MUJOCO_PLUGIN_BROADCAST_H
#define CF_MUJOCO_PLUGIN_BROADCAST_H

#include "mujoco_plugin/swarm.h"

#define CF_BROADCAST_PERIOD 10  // [ticks]: 100 Hz, as usual for motion capture

// Whether one of the ticks (before, now] starts with a broadcast. It is the time of the simulation
// that decides, so that a restored flight goes on alike.
bool cf_broadcast_is_due(double before, double now);

// Whether any drone wants positions of its peers.
bool cf_broadcast_has_listeners(const swarm_t *swarm);

// Takes the positions of all drones out of work[].motion.
void cf_broadcast_look(swarm_t *swarm);

// Tells drone i, when it listens, of its neighbors. Several threads may tell several drones.
void cf_broadcast_tell(const swarm_t *swarm, int i);

#endif  // CF_MUJOCO_PLUGIN_BROADCAST_H
