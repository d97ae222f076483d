/* Setpoints as bytes: the packets of the commander on ports 3 and 7, as cflib and older clients
 * send them.
 *
 * A packet whose length is not exactly that of its type, or in which a number is not finite, is
 * CF_ERR_VALUE and writes nothing; the firmware halts on the one and flies the other. Source:
 * docs/reference/planner-commander.md#8.4, #9 and #10, docs/reference/crtp-cflib.md#12. */
#ifndef CF_ONBOARD_PACKETS_SETPOINT_PACKETS_H
#define CF_ONBOARD_PACKETS_SETPOINT_PACKETS_H

#include <stdint.h>

#include "api/stabilizer_types.h"
#include "onboard/commander/cppm.h"
#include "status.h"

// First byte of a packet on port 7 channel 0. The legacy ones turn to the right at a positive yaw
// rate, all others to the left.
typedef enum {
  CF_GENERIC_STOP                  = 0,
  CF_GENERIC_LEGACY_VELOCITY_WORLD = 1,
  CF_GENERIC_LEGACY_ZDISTANCE      = 2,
  CF_GENERIC_CPPM                  = 3,
  CF_GENERIC_ALTITUDE_HOLD         = 4,
  CF_GENERIC_LEGACY_HOVER          = 5,
  CF_GENERIC_FULL_STATE            = 6,
  CF_GENERIC_POSITION              = 7,
  CF_GENERIC_VELOCITY_WORLD        = 8,
  CF_GENERIC_ZDISTANCE             = 9,
  CF_GENERIC_HOVER                 = 10,
  CF_GENERIC_MANUAL                = 11,
} cf_generic_type_t;

// First byte of a packet on port 7 channel 1.
typedef enum {
  CF_META_NOTIFY_SETPOINTS_STOP = 0,
} cf_meta_type_t;

// Port 7 channel 0. An unknown type makes the null setpoint, motors off, as in the firmware.
cf_status_t cf_generic_packet_decode(setpoint_t *setpoint, const cf_cppm_t *cppm,
                                     const uint8_t *data, int length);

// Port 7 channel 1. CF_OK means: low-level setpoints have ended. CF_ERR_UNKNOWN for another type.
cf_status_t cf_meta_packet_decode(const uint8_t *data, int length);

// What a packet on port 3 channel 0 says; onboard/commander/rpyt.h gives it a meaning.
typedef struct {
  float    roll;
  float    pitch;
  float    yaw;
  uint16_t thrust;
} cf_rpyt_packet_t;

cf_status_t cf_rpyt_packet_decode(cf_rpyt_packet_t *packet, const uint8_t *data, int length);

#endif  // CF_ONBOARD_PACKETS_SETPOINT_PACKETS_H
