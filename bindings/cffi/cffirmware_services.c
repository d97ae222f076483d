/* What the firmware calls and does not bring along on a host, for the module that
 * crazychoir_fw.cffirmware makes of a checkout. Weak, except for the assertion: a checkout that has
 * them uses its own. Compiled without the checkout's headers. */
#include <stdint.h>
#include <stdio.h>

#define WEAK __attribute__((weak))

void        assertFail(char *exp, char *file, int line);
const char *cf_upstream_take_assertion(void);
uint64_t    usecTimestamp(void);
uint32_t    xTaskGetTickCount(void);
uint16_t    logGetVarId(const char *group, const char *name);
float       logGetFloat(uint16_t id);
int         logGetInt(uint16_t id);
unsigned    logGetUint(uint16_t id);
int         consolePutchar(int character);
int         consolePuts(const char *text);
void        consoleFlush(void);

// of upstream's length
static _Thread_local char assertion[150];
static _Thread_local int  has_failed;

// Returns, as upstream's does: the Python wrapper raises the error after the call.
void assertFail(char *exp, char *file, int line) {
  if (!has_failed) {
    (void)snprintf(assertion, sizeof assertion, "%s in File: \"%s\", line %d\n", exp, file, line);
  }
  has_failed = 1;
}

const char *cf_upstream_take_assertion(void) {
  const char *text = has_failed ? assertion : NULL;
  has_failed       = 0;
  return text;
}

// there is no time here
WEAK uint64_t usecTimestamp(void) {
  return 0;
}

WEAK uint32_t xTaskGetTickCount(void) {
  return 0;
}

// no variable has this number
WEAK uint16_t logGetVarId(const char *group, const char *name) {
  (void)group;
  (void)name;
  return UINT16_MAX;
}

WEAK float logGetFloat(uint16_t id) {
  (void)id;
  return 0.0f;
}

WEAK int logGetInt(uint16_t id) {
  (void)id;
  return 0;
}

WEAK unsigned logGetUint(uint16_t id) {
  (void)id;
  return 0;
}

WEAK int consolePutchar(int character) {
  return character;
}

WEAK int consolePuts(const char *text) {
  (void)text;
  return 0;
}

WEAK void consoleFlush(void) {
}
