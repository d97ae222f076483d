#include "onboard/console.h"

#include <stddef.h>
#include <string.h>

void cf_console_init(cf_console_t *console) {
  memset(console, 0, sizeof *console);
}

static void put(cf_console_t *console, const char *part) {
  for (const char *c = part; c != NULL && *c != 0; c++) {
    console->text[console->written++ % CF_CONSOLE_BYTES] = *c;
  }
}

void cf_console_print(cf_console_t *console, const char *text) {
  put(console, text);
}

void cf_console_print_line(cf_console_t *console, const char *part1, const char *part2,
                           const char *part3) {
  put(console, part1);
  put(console, part1 != NULL ? part2 : NULL);
  put(console, part1 != NULL && part2 != NULL ? part3 : NULL);
  put(console, "\n");
}

int cf_console_read(const cf_console_t *console, uint32_t seen, char *text, int capacity,
                    uint32_t *first) {
  const uint32_t newer = console->written - seen;
  // more than the ring holds is lost; more than there is means another boot
  const uint32_t kept  = newer > CF_CONSOLE_BYTES ? CF_CONSOLE_BYTES : newer;
  const uint32_t start = console->written < kept ? 0 : console->written - kept;
  *first               = start;

  int count = 0;
  for (uint32_t n = start; n != console->written && count < capacity; n++) {
    text[count++] = console->text[n % CF_CONSOLE_BYTES];
  }
  return count;
}
