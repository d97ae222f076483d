/* The console: text that the onboard software prints for its readers.
 *
 * A ring of the latest characters. Readers remember how many characters they have seen, so that
 * reading changes nothing on the drone (docs/reference/crtp-cflib.md#11). */
#ifndef CF_ONBOARD_CONSOLE_H
#define CF_ONBOARD_CONSOLE_H

#include <stdint.h>

#define CF_CONSOLE_BYTES 512

typedef struct {
  uint32_t written;                 // characters since boot; the ring holds the latest of them
  char     text[CF_CONSOLE_BYTES];  // character n is at n modulo CF_CONSOLE_BYTES
} cf_console_t;

void cf_console_init(cf_console_t *console);

// Prints the parts in order and ends the line. A null part ends the list early.
void cf_console_print_line(cf_console_t *console, const char *part1, const char *part2,
                           const char *part3);

// Prints text as it is.
void cf_console_print(cf_console_t *console, const char *text);

// Copies what was printed after the first `seen` characters, oldest first and at most `capacity`,
// and returns how many characters were copied; `first` becomes the number of the first one, which
// is more than `seen` when older ones have left the ring.
int cf_console_read(const cf_console_t *console, uint32_t seen, char *text, int capacity,
                    uint32_t *first);

#endif  // CF_ONBOARD_CONSOLE_H
