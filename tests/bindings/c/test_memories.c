// Memories under the sanitizers: random places and bytes into drones that fly on them.

#include <math.h>
#include <string.h>

#include "check.h"
#include "memories.h"

#define WRITES 200000

static const uint8_t TYPES[] = {CF_MEMORY_EEPROM, CF_MEMORY_LED_RING, CF_MEMORY_LIGHTHOUSE,
                                CF_MEMORY_TESTER, CF_MEMORY_LED_TIMINGS};
#define N_TYPES ((uint32_t)sizeof TYPES)

static const cf_motion_t AT_REST = {.position       = {0.0f, 0.0f, 0.0145f},
                                    .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
                                    .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                    .specific_force = {0.0f, 0.0f, 9.81f}};

static uint32_t next(uint32_t *state) {
  *state ^= *state << 13;
  *state ^= *state >> 17;
  *state ^= *state << 5;
  return *state;
}

static void boot(cf_t *cf) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  config.vehicle.positioning = CF_POSITIONING_LIGHTHOUSE;
  CHECK(cf_init(cf, &config) == CF_OK);
}

// A write that is accepted is read back, but for the tester and truth values.
static void write_somewhere(cf_t *cf, uint32_t *random) {
  const uint8_t  type    = TYPES[next(random) % N_TYPES];
  const uint32_t wild    = next(random);
  const uint32_t address = next(random) % 8 == 0 ? wild : wild % (cf_memory_bytes(type) + 4);
  const uint32_t length  = next(random) % 30;
  uint8_t        data[30];
  uint8_t        back[30];
  for (uint32_t i = 0; i < length; i++) {
    data[i] = (uint8_t)next(random);
  }
  const bool        exists = cf_read_memory(cf, type, address, length, back) == CF_OK;
  const cf_status_t status = cf_write_memory(cf, type, address, length, data);
  CHECK(exists || status != CF_OK);
  if (status == CF_OK && type != CF_MEMORY_TESTER && type != CF_MEMORY_LIGHTHOUSE) {
    CHECK(cf_read_memory(cf, type, address, length, back) == CF_OK);
    CHECK(memcmp(data, back, length) == 0);
  }
}

static void check_random_writes(void) {
  static cf_t cf;
  uint32_t    random = 12345;
  boot(&cf);
  for (int i = 0; i < WRITES; i++) {
    write_somewhere(&cf, &random);
    if (i % 16 == 0) {
      cf_tick(&cf, &AT_REST);
    }
    if (i % 20000 == 0) {
      cf_reboot(&cf);
    }
  }
  CHECK(cf.onboard.system.memory_test_errors > 0);
}

static void check_refusals(void) {
  static cf_t cf;
  uint8_t     data[4] = {0};
  boot(&cf);
  for (int type = 0; type < 256; type++) {
    const bool is_listed = memchr(TYPES, type, sizeof TYPES) != NULL;
    CHECK((cf_memory_bytes((uint8_t)type) > 0) == is_listed);
    const cf_status_t expected = is_listed ? CF_OK : CF_ERR_UNKNOWN;
    CHECK(cf_read_memory(&cf, (uint8_t)type, 0, 4, data) == expected);
    CHECK(cf_write_memory(&cf, (uint8_t)type, UINT32_MAX, 1, data) != CF_OK);
    CHECK(cf_write_memory(&cf, (uint8_t)type, 0, UINT32_MAX, data) != CF_OK);
  }
  const float nothing = NAN;
  memcpy(data, &nothing, sizeof data);
  CHECK(cf_write_memory(&cf, CF_MEMORY_LIGHTHOUSE, 4, 4, data) == CF_ERR_VALUE);
  CHECK(cf_read_memory(&cf, CF_MEMORY_LIGHTHOUSE, 0x0200, 1, data) == CF_ERR_CAPACITY);
  CHECK(cf_read_memory(&cf, CF_MEMORY_LIGHTHOUSE, 0x0030, 2, data) == CF_ERR_CAPACITY);
  CHECK(cf_read_memory(&cf, CF_MEMORY_LIGHTHOUSE, 0x103C, 1, data) == CF_OK);
  CHECK(cf_read_memory(&cf, CF_MEMORY_LIGHTHOUSE, 0x103D, 1, data) == CF_ERR_CAPACITY);
}

int main(void) {
  check_refusals();
  check_random_writes();
  return 0;
}
