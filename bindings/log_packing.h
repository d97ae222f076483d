/* Log data: variables of drones in packets, as the firmware's log task sends them
 * (docs/reference/crtp-cflib.md#8.3). */
#ifndef CF_LOG_PACKING_H
#define CF_LOG_PACKING_H

#include <stdbool.h>
#include <stdint.h>

#include "crazyflie.h"

#define CF_LOG_VALUE_BYTES 26   // of values in one packet, and the most values in it
#define CF_LOG_HEADER_BYTES 5   // CRTP header, number of the block, time stamp
#define CF_LOG_PACKET_BYTES 31  // both

// Types by their numbers in the log service; from 1 to 7 these are those of cf_type_t plus 1.
#define CF_LOG_UINT8 1
#define CF_LOG_UINT16 2
#define CF_LOG_UINT32 3
#define CF_LOG_INT8 4
#define CF_LOG_INT16 5
#define CF_LOG_INT32 6
#define CF_LOG_FLOAT 7
#define CF_LOG_FP16 8  // only to fetch as

typedef struct {
  uint32_t offset;   // [bytes], within cf_t
  uint8_t  stored;   // CF_LOG_UINT8 to CF_LOG_FLOAT
  uint8_t  fetched;  // CF_LOG_UINT8 to CF_LOG_FP16
} cf_log_value_t;

typedef struct {
  cf_t          *drone;
  uint8_t        number;         // of the block, chosen by the client
  uint8_t        count;          // of values, which fill CF_LOG_VALUE_BYTES at most
  bool           needs_refresh;  // some values are computed only when they are read
  cf_log_value_t values[CF_LOG_VALUE_BYTES];
} cf_log_block_t;

// Bytes of a value on the way, 0 for a type that does not exist.
int cf_log_value_bytes(uint8_t fetched);

// Writes one packet per block, each at the next CF_LOG_PACKET_BYTES of `packets`, and brings what
// needs it up to date: once for neighbors of the same drone. The time stamps are the drones' own.
void cf_log_pack(const cf_log_block_t *blocks, int count, uint8_t *packets);

#endif  // CF_LOG_PACKING_H
