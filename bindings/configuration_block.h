/* The configuration block that a vehicle keeps in its EEPROM: radio channel, speed and address, and
 * the trims of the accelerometer (docs/reference/crtp-cflib.md#10.3).
 *
 *   "0xBC", u8 version, u8 channel, u8 speed, f32 pitch trim, f32 roll trim, version 1 also: u8
 *   high byte and u32 low bytes of the address; u8 sum of all bytes before
 *
 * The simulated radio has no channel and no speed; both are kept for clients. */
#ifndef CF_CONFIGURATION_BLOCK_H
#define CF_CONFIGURATION_BLOCK_H

#include <stdbool.h>
#include <stdint.h>

#define CF_CONFIGURATION_BYTES 32  // the block has 21

#define CF_RADIO_CHANNEL 80            // of a vehicle that was never configured
#define CF_RADIO_SPEED 2               // 2 Mbit/s
#define CF_RADIO_ADDRESS 996028180224  // 0xE7E7E7E700, with the radio id as its last byte

typedef struct {
  uint8_t  channel;      // 2400 MHz + channel
  uint8_t  speed;        // 0: 250 kbit/s, 1: 1 Mbit/s, 2: 2 Mbit/s
  float    pitch_trim;   // [deg], see cf_sensors_set_trim
  float    roll_trim;    // [deg]
  uint64_t address;      // 40 bits
  bool     has_address;  // false in blocks of version 0
} cf_configuration_t;

// Writes all bytes: a block of version 1, then zeros.
void cf_configuration_pack(uint8_t                   bytes[CF_CONFIGURATION_BYTES],
                           const cf_configuration_t *configuration);

// Reads a block. Returns false when it is none, of another version, damaged, or has trims that are
// not finite.
bool cf_configuration_unpack(const uint8_t       bytes[CF_CONFIGURATION_BYTES],
                             cf_configuration_t *configuration);

#endif  // CF_CONFIGURATION_BLOCK_H
