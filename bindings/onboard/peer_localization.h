/* Positions of other drones that this drone has received: a table of ten.
 *
 * Entries do not expire; readers compare the timestamps. Source:
 * docs/reference/planner-commander.md#13. */
#ifndef CF_ONBOARD_PEER_LOCALIZATION_H
#define CF_ONBOARD_PEER_LOCALIZATION_H

#include <stdbool.h>
#include <stdint.h>

#include "provider.h"

typedef struct {
  cf_peer_t peers[PEER_LOCALIZATION_MAX_NEIGHBORS];
} cf_peer_localization_t;

void cf_peer_localization_init(cf_peer_localization_t *table);

// Takes one position [m, world] at tick `now`, into the entry with this id (1 to 255) or the first
// empty one. Returns false, and forgets it, when there is neither; id 0 is never taken.
bool cf_peer_localization_tell(cf_peer_localization_t *table, uint8_t id, const float position[3],
                               uint32_t now);

// Takes all positions of one broadcast at tick `now`; of more than the table holds, the first ones.
// An id that is known keeps its entry; the others take empty entries, and then those of peers that
// are not in the broadcast. An id may stand there more than once: each has an entry of its own, so
// that swarms may be larger than the range of ids. Timestamps of the list are not looked at.
void cf_peer_localization_tell_all(cf_peer_localization_t *table, const cf_peer_t *list, int count,
                                   uint32_t now);

bool cf_peer_localization_is_id_active(const cf_peer_localization_t *table, uint8_t id);

// Null when no position with this id was received.
const cf_peer_t *cf_peer_localization_by_id(const cf_peer_localization_t *table, uint8_t id);

// Null unless 0 <= index < PEER_LOCALIZATION_MAX_NEIGHBORS; an empty entry has id 0.
const cf_peer_t *cf_peer_localization_by_index(const cf_peer_localization_t *table, int index);

#endif  // CF_ONBOARD_PEER_LOCALIZATION_H
