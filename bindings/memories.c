#include "memories.h"

#include <string.h>

#include "onboard/decks/lighthouse_memory.h"

#define TESTER_BYTES 0x1000u

uint32_t cf_memory_bytes(uint8_t type) {
  switch (type) {
    case CF_MEMORY_EEPROM:
      return CF_CONFIGURATION_BYTES;
    case CF_MEMORY_LED_RING:
      return CF_LED_RING_BYTES;
    case CF_MEMORY_LIGHTHOUSE:
      return CF_LIGHTHOUSE_MEMORY_BYTES;
    case CF_MEMORY_TESTER:
      return TESTER_BYTES;
    case CF_MEMORY_LED_TIMINGS:
      return CF_LED_TIMINGS_BYTES;
    default:
      return 0;
  }
}

static cf_status_t check(uint8_t type, uint32_t address, uint32_t length) {
  const uint32_t bytes = cf_memory_bytes(type);
  if (bytes == 0) {
    return CF_ERR_UNKNOWN;
  }
  return length <= bytes && address <= bytes - length ? CF_OK : CF_ERR_CAPACITY;
}

// The bytes of a memory that is nothing but bytes, or null.
static const uint8_t *plain_bytes(const cf_t *cf, uint8_t type) {
  switch (type) {
    case CF_MEMORY_EEPROM:
      return cf->configuration;
    case CF_MEMORY_LED_RING:
      return cf->onboard.lights.ring;
    case CF_MEMORY_LED_TIMINGS:
      return cf->onboard.lights.timings;
    default:
      return NULL;
  }
}

cf_status_t cf_read_memory(const cf_t *cf, uint8_t type, uint32_t address, uint32_t length,
                           uint8_t *data) {
  const cf_status_t status = check(type, address, length);
  if (status != CF_OK || length == 0) {
    return status;
  }
  if (type == CF_MEMORY_LIGHTHOUSE) {
    return cf_lighthouse_memory_read(&cf->onboard.estimator.stations, address, length, data);
  }
  if (type == CF_MEMORY_TESTER) {
    for (uint32_t i = 0; i < length; i++) {
      data[i] = (uint8_t)(address + i);
    }
    return CF_OK;
  }
  memcpy(data, plain_bytes(cf, type) + address, length);
  return CF_OK;
}

// What boot looks at follows the block as long as that is valid.
static void take_configuration(cf_t *cf) {
  cf_configuration_t configuration;
  if (!cf_configuration_unpack(cf->configuration, &configuration)) {
    return;
  }
  cf->config.acc_trim_pitch = configuration.pitch_trim;
  cf->config.acc_trim_roll  = configuration.roll_trim;
  const uint8_t id          = (uint8_t)configuration.address;
  // an address that ends with 0 cannot be told from one that is not chosen
  if (configuration.has_address && id != 0) {
    cf->config.radio_id = id;
  }
}

static void test(cf_system_variables_t *system, uint32_t address, uint32_t length,
                 const uint8_t *data) {
  for (uint32_t i = 0; i < length; i++) {
    if (data[i] != (uint8_t)(address + i)) {
      system->memory_test_errors++;
      return;
    }
  }
}

cf_status_t cf_write_memory(cf_t *cf, uint8_t type, uint32_t address, uint32_t length,
                            const uint8_t *data) {
  const cf_status_t status = check(type, address, length);
  if (status != CF_OK || length == 0) {
    return status;
  }
  switch (type) {
    case CF_MEMORY_EEPROM:
      memcpy(cf->configuration + address, data, length);
      take_configuration(cf);
      return CF_OK;
    case CF_MEMORY_LED_RING:
      memcpy(cf->onboard.lights.ring + address, data, length);
      return CF_OK;
    case CF_MEMORY_LED_TIMINGS:
      memcpy(cf->onboard.lights.timings + address, data, length);
      return CF_OK;
    case CF_MEMORY_LIGHTHOUSE:
      return cf_lighthouse_memory_write(&cf->onboard.estimator.stations, address, length, data);
    default:
      test(&cf->onboard.system, address, length, data);
      return CF_OK;
  }
}
