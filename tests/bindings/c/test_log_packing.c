// Log blocks under the sanitizers: the fullest packets, every pair of types, and numbers that no
// integer can hold.

#include "log_packing.h"

#include <float.h>
#include <math.h>
#include <stddef.h>
#include <string.h>

#include "check.h"

#define GUARD 0xA5

static const float WILD[] = {NAN, INFINITY, -INFINITY, FLT_MAX, -FLT_MAX, 2147483648.0f, -0.0f};

static void boot(cf_t *cf) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  CHECK(cf_init(cf, &config) == CF_OK);
}

static bool is_untouched(const uint8_t *bytes, int count) {
  for (int i = 0; i < count; i++) {
    if (bytes[i] != GUARD) {
      return false;
    }
  }
  return true;
}

static void test_a_full_packet_ends_where_it_must(void) {
  static cf_t    cf;
  cf_log_block_t block = {.drone = &cf, .number = 255, .count = CF_LOG_VALUE_BYTES};
  for (int i = 0; i < CF_LOG_VALUE_BYTES; i++) {
    // up to the last byte of the drone
    block.values[i] = (cf_log_value_t){.offset  = (uint32_t)(sizeof cf - 1 - (size_t)i),
                                       .stored  = CF_LOG_UINT8,
                                       .fetched = CF_LOG_UINT8};
  }
  cf.provider_state[CF_PROVIDER_STATE_BYTES / 8 - 1] = UINT64_MAX;

  uint8_t packets[CF_LOG_PACKET_BYTES + 8];
  memset(packets, GUARD, sizeof packets);
  cf_log_pack(&block, 1, packets);
  CHECK(packets[1] == 255 && packets[CF_LOG_HEADER_BYTES] == 0xFF);
  CHECK(is_untouched(packets + CF_LOG_PACKET_BYTES, 8));

  memset(packets, GUARD, sizeof packets);
  cf_log_pack(&block, 0, packets);
  CHECK(is_untouched(packets, (int)sizeof packets));
}

static void test_every_pair_of_types_survives_any_number(void) {
  static cf_t cf;
  for (size_t i = 0; i < sizeof WILD / sizeof WILD[0]; i++) {
    for (uint8_t stored = CF_LOG_UINT8; stored <= CF_LOG_FLOAT; stored++) {
      for (uint8_t fetched = CF_LOG_UINT8; fetched <= CF_LOG_FP16; fetched++) {
        const uint32_t offset = (uint32_t)offsetof(cf_t, provider_state) + 1;  // not aligned
        memcpy((char *)&cf + offset, &WILD[i], sizeof WILD[i]);
        const cf_log_block_t block = {
            .drone = &cf, .count = 1, .values = {{offset, stored, fetched}}};
        uint8_t packet[CF_LOG_PACKET_BYTES];
        memset(packet, GUARD, sizeof packet);
        cf_log_pack(&block, 1, packet);
        const int end = CF_LOG_HEADER_BYTES + cf_log_value_bytes(fetched);
        CHECK(is_untouched(packet + end, CF_LOG_PACKET_BYTES - end));
      }
    }
  }
}

static void test_every_log_variable_of_a_drone_can_be_packed(void) {
  static cf_t cf;
  boot(&cf);
  cf_variables_t tables[64];
  const int      count = cf_logs(0, tables, 64);
  CHECK(count > 0 && count <= 64);
  for (int t = 0; t < count; t++) {
    for (int r = 0; r < tables[t].count; r++) {
      const cf_variable_t *row   = &tables[t].rows[r];
      const cf_log_block_t block = {
          .drone         = &cf,
          .count         = 1,
          .needs_refresh = true,
          .values        = {{tables[t].base + row->offset, (uint8_t)(row->type + 1), CF_LOG_FP16}}};
      uint8_t packet[CF_LOG_PACKET_BYTES];
      cf_log_pack(&block, 1, packet);
      CHECK(packet[0] == 0x5E);
    }
  }
}

int main(void) {
  test_a_full_packet_ends_where_it_must();
  test_every_pair_of_types_survives_any_number();
  test_every_log_variable_of_a_drone_can_be_packed();
  return 0;
}
