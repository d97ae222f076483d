/* Fetching the state of a drone into the cache before its turn comes. Internal to the plugin.
 *
 * A tick touches 70 cache lines of a drone, in a dozen places. A swarm that fits into the cache of
 * a core, some 300 drones, finds them there; a larger one waits for each of them, unless they are
 * asked for while another drone ticks. */
#ifndef CF_MUJOCO_PLUGIN_PREFETCH_H
#define CF_MUJOCO_PLUGIN_PREFETCH_H

#include "mujoco_plugin/swarm.h"

// Whether the swarm is larger than the cache of a core. For a smaller one asking costs more than
// it brings.
bool cf_prefetch_pays(const swarm_t *swarm);

// Asks for what a tick of a hovering drone touches. Changes nothing but time.
void cf_prefetch(const cf_t *cf);

#endif  // CF_MUJOCO_PLUGIN_PREFETCH_H
