#include "configuration_block.h"

#include <math.h>
#include <string.h>

#include "little_endian.h"

#define VERSION 4  // place of the version, behind the token
#define CHANNEL 5
#define SPEED 6
#define PITCH_TRIM 7
#define ROLL_TRIM 11
#define SUM_0 15  // of version 0
#define ADDRESS_HIGH 15
#define ADDRESS_LOW 16
#define SUM_1 20  // of version 1

static const uint8_t TOKEN[4] = {'0', 'x', 'B', 'C'};

static uint8_t sum(const uint8_t *bytes, int count) {
  unsigned sum = 0;
  for (int i = 0; i < count; i++) {
    sum += bytes[i];
  }
  return (uint8_t)sum;
}

void cf_configuration_pack(uint8_t                   bytes[CF_CONFIGURATION_BYTES],
                           const cf_configuration_t *configuration) {
  memset(bytes, 0, CF_CONFIGURATION_BYTES);
  memcpy(bytes, TOKEN, sizeof TOKEN);
  bytes[VERSION] = 1;
  bytes[CHANNEL] = configuration->channel;
  bytes[SPEED]   = configuration->speed;
  cf_put_le_float(bytes + PITCH_TRIM, configuration->pitch_trim);
  cf_put_le_float(bytes + ROLL_TRIM, configuration->roll_trim);
  bytes[ADDRESS_HIGH] = (uint8_t)(configuration->address >> 32);
  cf_put_le_u32(bytes + ADDRESS_LOW, (uint32_t)configuration->address);
  bytes[SUM_1] = sum(bytes, SUM_1);
}

bool cf_configuration_unpack(const uint8_t       bytes[CF_CONFIGURATION_BYTES],
                             cf_configuration_t *configuration) {
  const bool has_address = bytes[VERSION] == 1;
  const int  end         = has_address ? SUM_1 : SUM_0;
  if (memcmp(bytes, TOKEN, sizeof TOKEN) != 0 || bytes[VERSION] > 1 ||
      bytes[end] != sum(bytes, end)) {
    return false;
  }
  *configuration = (cf_configuration_t){
      .channel     = bytes[CHANNEL],
      .speed       = bytes[SPEED],
      .pitch_trim  = cf_le_float(bytes + PITCH_TRIM),
      .roll_trim   = cf_le_float(bytes + ROLL_TRIM),
      .has_address = has_address,
  };
  if (has_address) {
    configuration->address = (uint64_t)bytes[ADDRESS_HIGH] << 32 | cf_le_u32(bytes + ADDRESS_LOW);
  }
  return isfinite(configuration->pitch_trim) && isfinite(configuration->roll_trim);
}
