/* The memories of a drone that clients read and write by type and address, apart from that of the
 * trajectories (`cf_write_trajectory`) and those that cannot be written.
 *
 * Types and layouts: docs/reference/crtp-cflib.md#10. The sizes of the EEPROM and of the LED
 * timings are not established; those chosen here hold what the client writes. */
#ifndef CF_MEMORIES_H
#define CF_MEMORIES_H

#include "crazyflie.h"

// Types as clients know them.
typedef enum {
  CF_MEMORY_EEPROM      = 0x00,  // configuration_block.h
  CF_MEMORY_LED_RING    = 0x10,  // onboard/lights.h
  CF_MEMORY_LIGHTHOUSE  = 0x14,  // onboard/decks/lighthouse_memory.h
  CF_MEMORY_TESTER      = 0x15,  // byte at address a is a; nothing is kept
  CF_MEMORY_LED_TIMINGS = 0x17,  // onboard/lights.h
} cf_memory_t;

// Pure: bytes of a memory, 0 for a type that is not listed above.
uint32_t cf_memory_bytes(uint8_t type);

// Copies bytes out of a memory. CF_ERR_UNKNOWN for a type that is not listed above,
// CF_ERR_CAPACITY when some of the bytes do not exist.
cf_status_t cf_read_memory(const cf_t *cf, uint8_t type, uint32_t address, uint32_t length,
                           uint8_t *data);

// Writes bytes into a memory; refusals as for reading, and CF_ERR_VALUE where a number would not be
// finite. A valid configuration block in the EEPROM counts from the next boot on; geometry and
// calibration are used at once; the memory tester counts bytes that differ from its pattern.
cf_status_t cf_write_memory(cf_t *cf, uint8_t type, uint32_t address, uint32_t length,
                            const uint8_t *data);

#endif  // CF_MEMORIES_H
