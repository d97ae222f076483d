/* The localization service as bytes, port 6: where vehicles are by an external system, and the
 * emergency stop of older clients.
 *
 * A packet of a wrong length, or with a number that is not finite, is CF_ERR_VALUE as a whole; the
 * firmware takes such numbers into its estimator. Source: docs/reference/crtp-cflib.md#14. */
#ifndef CF_ONBOARD_PACKETS_LOCALIZATION_PACKETS_H
#define CF_ONBOARD_PACKETS_LOCALIZATION_PACKETS_H

#include <stdint.h>

#include "onboard/packets/packet.h"
#include "status.h"

#define CF_LOCALIZATION_POSITION 0  // channels
#define CF_LOCALIZATION_GENERIC 1
#define CF_LOCALIZATION_PACKED_POSITIONS 2

// First byte on the generic channel, from client to vehicle.
typedef enum {
  CF_LOCALIZATION_LPS_SHORT          = 2,
  CF_LOCALIZATION_EMERGENCY_STOP     = 3,
  CF_LOCALIZATION_EMERGENCY_WATCHDOG = 4,
  CF_LOCALIZATION_POSE               = 8,
  CF_LOCALIZATION_PACKED_POSES       = 9,
  CF_LOCALIZATION_LIGHTHOUSE_PERSIST = 11,
} cf_localization_type_t;

// What a packet asks for.
typedef enum {
  CF_LOCALIZATION_ASKS_NOTHING       = 0,
  CF_LOCALIZATION_ASKS_TO_STOP       = 1,  // the motors, for good
  CF_LOCALIZATION_ASKS_TO_WATCH      = 2,  // feeds the emergency watchdog
  CF_LOCALIZATION_ASKS_FOR_AN_ANSWER = 3,  // in `reply`
} cf_localization_request_t;

typedef struct {
  cf_localization_request_t request;
  int                       n_items;
  cf_located_t              items[CF_PACKET_MAX_LOCATED];  // in the order of the packet

  // LPS short packets and lighthouse data need decks that are not simulated: the answer says no
  int     reply_length;  // [bytes]
  uint8_t reply[3];
} cf_localization_packet_t;

// Takes a packet apart. What names no vehicle is about own_id. Returns CF_ERR_UNKNOWN for a channel
// or type that does not exist; *packet is written only when CF_OK.
cf_status_t cf_localization_packet_decode(cf_localization_packet_t *packet, uint8_t own_id,
                                          uint8_t channel, const uint8_t *data, int length);

#endif  // CF_ONBOARD_PACKETS_LOCALIZATION_PACKETS_H
