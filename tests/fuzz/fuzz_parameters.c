/* Any bits in any parameter that a client may write, any number of them. */
#include <string.h>

#include "fuzz.h"

#define MAX_TABLES 64

static const int SIZES[] = {1, 2, 4, 1, 2, 4, 4};  // of cf_type_t

static void write_parameter(cf_t *cf, fuzz_input_t *input) {
  static cf_variables_t tables[MAX_TABLES];
  const int             count  = cf_parameters(0, tables, MAX_TABLES);
  int                   wanted = fuzz_u16(input);
  uint8_t               value[4];
  fuzz_bytes(input, value, sizeof value);

  int total = 0;
  for (int i = 0; i < count; i++) {
    total += tables[i].count;
  }
  wanted %= total;
  for (int i = 0; i < count; i++) {
    if (wanted < tables[i].count) {
      const cf_variable_t *row = &tables[i].rows[wanted];
      if ((row->flags & CF_READ_ONLY) == 0) {
        memcpy((char *)cf + tables[i].base + row->offset, value, (size_t)SIZES[row->type]);
      }
      return;
    }
    wanted -= tables[i].count;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static cf_t  cf;
  fuzz_input_t input = {data, size};
  fuzz_hovering_drone(&cf, fuzz_u8(&input));
  while (input.left > 0) {
    write_parameter(&cf, &input);
    fuzz_run(&cf, fuzz_u8(&input) % 32);
  }
  fuzz_run(&cf, 50);
  return 0;
}
