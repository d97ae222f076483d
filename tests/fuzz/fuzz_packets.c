/* Any bytes as packets of any port, between ticks. */
#include "commands.h"
#include "fuzz.h"

// those that a drone listens to, and one that it does not
static const uint8_t PORTS[] = {3, 6, 7, 8, 9, 13};

static void receive(cf_t *cf, fuzz_input_t *input) {
  const uint8_t     header = fuzz_u8(input);
  const uint8_t     length = fuzz_u8(input) % (CF_PACKET_BYTES + 2);
  uint8_t           data[CF_PACKET_BYTES + 2];
  cf_packet_reply_t reply;
  fuzz_bytes(input, data, length);
  cf_receive_packet(cf, PORTS[header % sizeof PORTS], header / 64, data, length, &reply);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  static cf_t  cf;
  fuzz_input_t input = {data, size};
  fuzz_hovering_drone(&cf, fuzz_u8(&input));
  while (input.left > 0) {
    receive(&cf, &input);
    fuzz_run(&cf, fuzz_u8(&input) % 16);
  }
  fuzz_run(&cf, 50);
  return 0;
}
