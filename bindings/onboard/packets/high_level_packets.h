/* Packets of CRTP port 8 for the high-level commander: a command byte, then a packed little-endian
 * record, answered by four bytes (docs/reference/planner-commander.md#7.1 and #7.2).
 *
 * Every byte is checked before it is used. Deviations from the firmware, which does not check: a
 * record that is too short, a number that is not finite, a duration or timescale that is not
 * positive, and a definition that does not lie within the trajectory memory are answered with
 * CF_HIGH_LEVEL_REPLY_NOEXEC and change nothing. Bytes behind a record are ignored, as there. */
#ifndef CF_ONBOARD_PACKETS_HIGH_LEVEL_PACKETS_H
#define CF_ONBOARD_PACKETS_HIGH_LEVEL_PACKETS_H

#include <stdint.h>

#include "onboard/commander/high_level_commander.h"
#include "provider.h"

#define CF_HIGH_LEVEL_REPLY_BYTES 4

// Return codes, the last byte of a reply.
typedef enum {
  CF_HIGH_LEVEL_REPLY_OK      = 0,   // done, or not meant for this vehicle
  CF_HIGH_LEVEL_REPLY_REFUSED = 1,   // by the planner: take-off while flying, landing while landing
  CF_HIGH_LEVEL_REPLY_NOEXEC  = 8,   // unknown command, malformed record, bad value
  CF_HIGH_LEVEL_REPLY_BUSY    = 16,  // blocked by the supervisor
} cf_high_level_reply_t;

// Carries out a packet of `size` bytes. Returns the number of bytes of the reply: 4 (command, the
// two bytes that followed it, or 0, and a return code), or none to an empty packet. Starting a
// trajectory that is not defined is answered with CF_HIGH_LEVEL_REPLY_OK and does nothing.
int cf_high_level_commander_packet(cf_high_level_commander_t *commander,
                                   const cf_provider_t *provider, void *provider_state,
                                   const uint8_t *data, uint32_t size, uint64_t now_us,
                                   uint8_t reply[CF_HIGH_LEVEL_REPLY_BYTES]);

#endif  // CF_ONBOARD_PACKETS_HIGH_LEVEL_PACKETS_H
