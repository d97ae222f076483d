/* The supervisor as bytes, port 9: questions on channel 0, commands on channel 1
 * (docs/reference/planner-commander.md#14.10, docs/reference/crtp-cflib.md#7). */
#ifndef CF_ONBOARD_PACKETS_SUPERVISOR_PACKETS_H
#define CF_ONBOARD_PACKETS_SUPERVISOR_PACKETS_H

#include <stdint.h>

#include "onboard/packets/packet.h"
#include "onboard/supervisor.h"
#include "status.h"

#define CF_SUPERVISOR_CHANNEL_INFO 0
#define CF_SUPERVISOR_CHANNEL_COMMAND 1

// Questions. Those up to HL_DISABLED are answered with 0 or 1, BITFIELD with all of the log
// supervisor.info.
typedef enum {
  CF_SUPERVISOR_QUERY_CAN_ARM     = 1,
  CF_SUPERVISOR_QUERY_IS_ARMED    = 2,
  CF_SUPERVISOR_QUERY_AUTO_ARM    = 3,
  CF_SUPERVISOR_QUERY_CAN_FLY     = 4,
  CF_SUPERVISOR_QUERY_IS_FLYING   = 5,
  CF_SUPERVISOR_QUERY_IS_TUMBLED  = 6,
  CF_SUPERVISOR_QUERY_IS_LOCKED   = 7,
  CF_SUPERVISOR_QUERY_IS_CRASHED  = 8,
  CF_SUPERVISOR_QUERY_HL_ACTIVE   = 9,
  CF_SUPERVISOR_QUERY_HL_FINISHED = 10,
  CF_SUPERVISOR_QUERY_HL_DISABLED = 11,
  CF_SUPERVISOR_QUERY_BITFIELD    = 12,
} cf_supervisor_query_t;

// Commands. The first two are answered with success and the new state, the others not at all.
typedef enum {
  CF_SUPERVISOR_COMMAND_ARM                = 1,
  CF_SUPERVISOR_COMMAND_RECOVER            = 2,
  CF_SUPERVISOR_COMMAND_EMERGENCY_STOP     = 3,
  CF_SUPERVISOR_COMMAND_EMERGENCY_WATCHDOG = 4,
} cf_supervisor_command_t;

// Obeys or answers one packet at tick now [ms]; fills length and data of the reply when there is an
// answer. A command that is refused, such as arming while tumbled, is CF_OK with an answer that
// says so. CF_ERR_UNKNOWN for another channel or number, CF_ERR_VALUE for a wrong length; neither
// is answered, and nothing changes.
cf_status_t cf_supervisor_packet(cf_supervisor_t *supervisor, uint32_t now, uint8_t channel,
                                 const uint8_t *data, int length, cf_packet_reply_t *reply);

#endif  // CF_ONBOARD_PACKETS_SUPERVISOR_PACKETS_H
