#ifndef __PEER_LOCALIZATION_H__
#define __PEER_LOCALIZATION_H__

#include <stdbool.h>

#include "math3d.h"
#include "stabilizer_types.h"

#define PEER_LOCALIZATION_MAX_NEIGHBORS 10

typedef struct peerLocalizationOtherPosition_s {
  uint8_t id;
  point_t pos;  // with the time of its reception
} peerLocalizationOtherPosition_t;

void peerLocalizationInit();
bool peerLocalizationTest();
bool peerLocalizationTellPosition(int id, positionMeasurement_t const *pos);
bool peerLocalizationIsIDActive(uint8_t id);
peerLocalizationOtherPosition_t *peerLocalizationGetPositionByID(uint8_t id);
peerLocalizationOtherPosition_t *peerLocalizationGetPositionByIdx(uint8_t idx);

#endif  // __PEER_LOCALIZATION_H__
