/* Collision avoidance on the drone: parameters colAv.*, memory, and the peers that count.
 *
 * The law itself is in api/collision_avoidance.h. Source: docs/reference/planner-commander.md#12.1,
 * #12.6 and #16. */
#ifndef CF_BUILTIN_PLANNING_COLLISION_AVOIDANCE_H
#define CF_BUILTIN_PLANNING_COLLISION_AVOIDANCE_H

#include <stdint.h>

#include "api/collision_avoidance.h"
#include "provider.h"
#include "variables.h"

// A client may ask for any number of sweeps; more than this would not fit into a millisecond.
#define CF_COLLISION_AVOIDANCE_MAX_SWEEPS 1000

typedef struct {
  // parameters
  uint8_t                      enable;  // 0: off
  collision_avoidance_params_t params;

  collision_avoidance_state_t state;
  uint32_t latency;  // [ticks] that the last update took: 0, computing is instant
} cf_collision_avoidance_t;

// Off, with the stock parameters.
void cf_collision_avoidance_init(cf_collision_avoidance_t *avoidance);

// Bends the setpoint away from the peers when enabled. Peers with id 0, and those told longer ago
// than maxPeerLocAge, do not count; of the table, the first PEER_LOCALIZATION_MAX_NEIGHBORS entries
// are looked at. `now` [ms] is the drone's tick.
void cf_collision_avoidance_update(cf_collision_avoidance_t *avoidance, setpoint_t *setpoint,
                                   const cf_peer_t *peers, int n_peers, const sensorData_t *sensors,
                                   const state_t *estimate, uint32_t now);

// Tables of colAv, offsets relative to cf_collision_avoidance_t.
cf_variables_t cf_collision_avoidance_parameters(void);
cf_variables_t cf_collision_avoidance_logs(void);

#endif  // CF_BUILTIN_PLANNING_COLLISION_AVOIDANCE_H
