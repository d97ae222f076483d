// Positions of other drones that this drone has received.
#include "peer_localization.h"

#include "FreeRTOS.h"
#include "task.h"

// id 0: an unused entry
static peerLocalizationOtherPosition_t other_positions[PEER_LOCALIZATION_MAX_NEIGHBORS];

void peerLocalizationInit() {
}

bool peerLocalizationTest() {
  return true;
}

bool peerLocalizationTellPosition(int cfid, positionMeasurement_t const *pos) {
  for (uint8_t i = 0; i < PEER_LOCALIZATION_MAX_NEIGHBORS; i++) {
    peerLocalizationOtherPosition_t *other = &other_positions[i];
    if (other->id == 0 || other->id == cfid) {
      other->id            = cfid;
      other->pos.x         = pos->x;
      other->pos.y         = pos->y;
      other->pos.z         = pos->z;
      other->pos.timestamp = xTaskGetTickCount();
      return true;
    }
  }
  return false;
}

bool peerLocalizationIsIDActive(uint8_t cfid) {
  return peerLocalizationGetPositionByID(cfid) != NULL;
}

peerLocalizationOtherPosition_t *peerLocalizationGetPositionByID(uint8_t cfid) {
  for (uint8_t i = 0; i < PEER_LOCALIZATION_MAX_NEIGHBORS; i++) {
    if (cfid != 0 && other_positions[i].id == cfid) {
      return &other_positions[i];
    }
  }
  return NULL;
}

peerLocalizationOtherPosition_t *peerLocalizationGetPositionByIdx(uint8_t idx) {
  return idx < PEER_LOCALIZATION_MAX_NEIGHBORS ? &other_positions[idx] : NULL;
}
