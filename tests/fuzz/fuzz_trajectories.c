/* Any bytes in trajectory memory, flown with any options. */
#include "commands.h"
#include "fuzz.h"

static void write_memory(cf_t *cf, fuzz_input_t *input) {
  uint8_t        bytes[600];
  const uint16_t offset = fuzz_u16(input) % 4200;
  const uint16_t length = fuzz_u16(input) % sizeof bytes;
  fuzz_bytes(input, bytes, length);
  cf_write_trajectory(cf, offset, length, bytes);
}

static void command(cf_t *cf, fuzz_input_t *input) {
  const uint8_t what  = fuzz_u8(input);
  const uint8_t flags = fuzz_u8(input);
  switch (what % 5) {
    case 0:
      write_memory(cf, input);
      break;
    case 1:
      cf_define_trajectory(cf, flags % 32, flags / 64, fuzz_u16(input) % 4200, fuzz_u8(input));
      break;
    case 2:
      cf_start_trajectory(cf, flags / 8, fuzz_float(input), flags & 1, flags & 2, flags & 4);
      break;
    case 3:
      cf_go_to(cf, fuzz_float(input), fuzz_float(input), fuzz_float(input), fuzz_float(input),
               fuzz_float(input), flags & 1, flags & 2);
      break;
    default:
      cf_land(cf, fuzz_float(input), fuzz_float(input), fuzz_float(input), flags & 1);
      break;
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static cf_t  cf;
  fuzz_input_t input = {data, size};
  fuzz_hovering_drone(&cf, fuzz_u8(&input));
  while (input.left > 0) {
    command(&cf, &input);
    fuzz_run(&cf, 4 * (fuzz_u8(&input) % 32));
  }
  fuzz_run(&cf, 50);
  return 0;
}
