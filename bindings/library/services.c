#include "library/services.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "library/inner.h"

#define WEAK __attribute__((weak))

// ------------------------------------------------------------------------------------------- time

WEAK uint64_t usecTimestamp(void) {
  return (uint64_t)cf_library_now_ms() * 1000;
}

WEAK uint32_t xTaskGetTickCount(void) {
  return cf_library_now_ms();
}

WEAK void vTaskDelay(uint32_t ticks) {
  (void)ticks;
}

// ---------------------------------------------------------------------------------------- console

// A line that is not complete yet, a part of the image.
#define LINE_BYTES 120
static struct {
  char text[LINE_BYTES];
  int  length;
} line;

static void print_line(void) {
  line.text[line.length] = 0;
  line.length            = 0;
  cf_library_print(line.text);
}

WEAK int consolePutchar(int ch) {
  line.text[line.length++] = (char)ch;
  if (ch == '\n' || line.length == LINE_BYTES - 1) {
    print_line();
  }
  return (unsigned char)ch;
}

WEAK int consolePutcharFromISR(int ch) {
  return consolePutchar(ch);
}

WEAK int consolePuts(const char *text) {
  for (const char *c = text; *c != 0; c++) {
    consolePutchar(*c);
  }
  return (int)strlen(text);
}

WEAK void consoleFlush(void) {
  if (line.length > 0) {
    print_line();
  }
}

#define PRINTED_BYTES 512

WEAK int consolePrintf(const char *format, ...) {
  char    text[PRINTED_BYTES];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  return consolePuts(text);
}

WEAK int eprintf(int (*put)(int), const char *format, ...) {
  char    text[PRINTED_BYTES];
  va_list arguments;
  va_start(arguments, format);
  vsnprintf(text, sizeof text, format, arguments);
  va_end(arguments);
  int length = 0;
  for (; text[length] != 0; length++) {
    put(text[length]);
  }
  return length;
}

// -------------------------------------------------------------------------------------- assertions

static const char *base_name(const char *path) {
  const char *slash = strrchr(path, '/');
  return slash != NULL ? slash + 1 : path;
}

WEAK void assertFail(char *expression, char *file, int line_number) {
  char reason[200];
  snprintf(reason, sizeof reason, "assertion '%s' failed in %s:%d", expression, base_name(file),
           line_number);
  cf_library_fail(reason);
}
