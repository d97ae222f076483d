/* What the onboard software knows of the base stations, as the bytes of a memory
 * (docs/reference/crtp-cflib.md#10.3): one page for the geometry of each and one for its
 * calibration.
 *
 *   0x0000 + k * 0x100  origin 3 f32, rotation 9 f32 row by row, u8 valid
 *   0x1000 + k * 0x100  twice phase, tilt, curve, gibmag, gibphase, ogeemag, ogeephase f32; u32
 * uid, u8 valid
 */
#ifndef CF_ONBOARD_DECKS_LIGHTHOUSE_MEMORY_H
#define CF_ONBOARD_DECKS_LIGHTHOUSE_MEMORY_H

#include <stdint.h>

#include "onboard/decks/base_stations.h"
#include "status.h"

#define CF_LIGHTHOUSE_MEMORY_BYTES 0x2000

// Copies bytes of one page. CF_ERR_CAPACITY when they are not within one.
cf_status_t cf_lighthouse_memory_read(const cf_base_stations_t *stations, uint32_t address,
                                      uint32_t length, uint8_t *data);

// Writes bytes of one page, which count at once; likewise, and CF_ERR_VALUE when a number of the
// page would not be finite.
cf_status_t cf_lighthouse_memory_write(cf_base_stations_t *stations, uint32_t address,
                                       uint32_t length, const uint8_t *data);

#endif  // CF_ONBOARD_DECKS_LIGHTHOUSE_MEMORY_H
