#include "onboard/peer_localization.h"

#include <stddef.h>
#include <string.h>

#define COUNT PEER_LOCALIZATION_MAX_NEIGHBORS
#define EMPTY 0  // the id of an unused entry

void cf_peer_localization_init(cf_peer_localization_t *table) {
  memset(table, 0, sizeof *table);
}

static void write(cf_peer_t *peer, uint8_t id, float x, float y, float z, uint32_t now) {
  peer->id  = id;
  peer->pos = (point_t){.timestamp = now, .x = x, .y = y, .z = z};
}

bool cf_peer_localization_tell(cf_peer_localization_t *table, uint8_t id, const float position[3],
                               uint32_t now) {
  if (id == EMPTY) {
    return false;
  }
  for (int i = 0; i < COUNT; i++) {
    cf_peer_t *peer = &table->peers[i];
    if (peer->id == id || peer->id == EMPTY) {
      write(peer, id, position[0], position[1], position[2], now);
      return true;
    }
  }
  return false;
}

// First entry with this id that this broadcast has not written yet, or -1.
static int find(const cf_peer_localization_t *table, uint8_t id, const bool *is_written) {
  for (int i = 0; i < COUNT; i++) {
    if (table->peers[i].id == id && !is_written[i]) {
      return i;
    }
  }
  return -1;
}

static int find_other(const bool *is_written) {
  int i = 0;
  while (i < COUNT - 1 && is_written[i]) {
    i++;
  }
  return i;
}

void cf_peer_localization_tell_all(cf_peer_localization_t *table, const cf_peer_t *list, int count,
                                   uint32_t now) {
  const int most              = count < COUNT ? count : COUNT;
  bool      is_written[COUNT] = {false};
  bool      is_new[COUNT]     = {false};
  for (int k = 0; k < most; k++) {
    const cf_peer_t *peer = &list[k];
    const int        i    = peer->id == EMPTY ? -1 : find(table, peer->id, is_written);
    is_new[k]             = i < 0 && peer->id != EMPTY;
    if (i >= 0) {
      write(&table->peers[i], peer->id, peer->pos.x, peer->pos.y, peer->pos.z, now);
      is_written[i] = true;
    }
  }
  for (int k = 0; k < most; k++) {
    if (is_new[k]) {
      const cf_peer_t *peer  = &list[k];
      const int        empty = find(table, EMPTY, is_written);
      const int        i     = empty >= 0 ? empty : find_other(is_written);
      write(&table->peers[i], peer->id, peer->pos.x, peer->pos.y, peer->pos.z, now);
      is_written[i] = true;
    }
  }
}

const cf_peer_t *cf_peer_localization_by_id(const cf_peer_localization_t *table, uint8_t id) {
  for (int i = 0; i < COUNT; i++) {
    if (table->peers[i].id == id && id != EMPTY) {
      return &table->peers[i];
    }
  }
  return NULL;
}

bool cf_peer_localization_is_id_active(const cf_peer_localization_t *table, uint8_t id) {
  return cf_peer_localization_by_id(table, id) != NULL;
}

const cf_peer_t *cf_peer_localization_by_index(const cf_peer_localization_t *table, int index) {
  return index >= 0 && index < COUNT ? &table->peers[index] : NULL;
}
