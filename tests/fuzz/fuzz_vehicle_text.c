/* Any text as the attribute `vehicle`: what is refused says why, what is accepted can be built and
 * flown, or is refused by the vehicle. */
#include <math.h>
#include <string.h>

#include "fuzz.h"
#include "vehicle/parameters.h"

#define LONGEST 900
#define TICKS 5

static void check(bool is_right) {
  if (!is_right) {
    __builtin_trap();
  }
}

// Adds text as far as it fits.
static void append(char text[LONGEST], const char *more) {
  strncat(text, more, LONGEST - 1 - strlen(text));
}

// Names that exist and numbers that break programs, so that most texts come past the first word.
static void append_word(char text[LONGEST], fuzz_input_t *input) {
  static const char *const VALUES[] = {
      "=",       "=0",     "=1",       "=-1",  "=1e-4", "=0.05",    "=nan", "=inf",   "=1e999",
      "=0,0,0",  "=1,1,1", "=1,1,1,1", "=on",  "=off",  "=linear",  "==1",  "=1,",    "=,,,",
      "=0x1p-3", "= 1",    "=+1",      "=1 2", "",      "=1e-4000", "=.",   "=\t0.5", "=quadratic",
  };
  const int     wanted = fuzz_u8(input) % (cf_parameter_count() + 1);
  const uint8_t value  = fuzz_u8(input);
  if (wanted == cf_parameter_count()) {
    char letters[8] = {0};
    fuzz_bytes(input, letters, sizeof letters - 1);
    append(text, letters);
  } else {
    append(text, cf_parameter_facts(wanted)->name);
  }
  append(text, VALUES[value % (sizeof VALUES / sizeof VALUES[0])]);
  append(text, value & 0x80 ? "  " : " ");
}

static void fly(const cf_vehicle_config_t *config) {
  static cf_vehicle_t vehicle;
  if (cf_vehicle_init(&vehicle, config, 1, 0) != CF_OK) {
    return;
  }
  static const float    EYE[9]    = {1.0f, 0.0f, 0.0f, 0.0f, 1.0f, 0.0f, 0.0f, 0.0f, 1.0f};
  static const float    AT[3]     = {0.0f, 0.0f, 0.5f};
  static const float    SLOW[3]   = {0.1f, -0.2f, 0.3f};
  static const uint16_t RATIOS[4] = {40000, 65535, 0, 30000};
  for (int i = 0; i < TICKS; i++) {
    float force[3], torque[3];
    cf_vehicle_actuate(&vehicle, RATIOS);
    cf_vehicle_feel_air(&vehicle, AT, EYE, SLOW);
    cf_vehicle_wrench(&vehicle, EYE, SLOW, SLOW, force, torque);
    for (int k = 0; k < 3; k++) {
      check(isfinite(force[k]) && isfinite(torque[k]));
    }
  }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  fuzz_input_t input         = {data, size};
  char         text[LONGEST] = {0};
  char         message[CF_PARAMETER_MESSAGE_BYTES];
  const bool   is_plain = fuzz_u8(&input) % 4 == 0;
  if (is_plain) {
    fuzz_bytes(&input, text, size < LONGEST ? size : LONGEST - 1);
  }
  while (!is_plain && input.left > 0) {
    append_word(text, &input);
  }

  cf_vehicle_config_t config;
  check(cf_vehicle_default_config(&config, size % 2 ? CF_PLATFORM_CF21BL : CF_PLATFORM_CF2) ==
        CF_OK);
  memset(message, 'x', sizeof message);
  const cf_status_t status = cf_parameters_set(&config, text, message);
  if (status == CF_OK) {
    fly(&config);
  } else {
    check(status == CF_ERR_UNKNOWN || status == CF_ERR_VALUE);
    check(memchr(message, 0, sizeof message) != NULL && message[0] != 0);
  }
  return 0;
}
