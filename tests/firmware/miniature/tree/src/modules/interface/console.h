// Text for the client, a character at a time.
#ifndef CONSOLE_H_
#define CONSOLE_H_

#include <stdbool.h>
#if MINIATURE_RELEASE >= 202608
#include <stddef.h>
#include <stdint.h>
#endif

#include "eprintf.h"

void consoleInit(void);
bool consoleTest(void);
int  consolePutchar(int ch);
int  consolePutcharFromISR(int ch);
int  consolePuts(const char *str);
void consoleFlush(void);

#define consolePrintf(FMT, ...) eprintf(consolePutchar, FMT, ##__VA_ARGS__)
#if MINIATURE_RELEASE >= 202608

// a source of console text, and whether its text is sent
typedef struct ConsoleSource {
  const char           *path;
  struct ConsoleSource *next;
  uint8_t               id;
  uint8_t               pathLength;
  volatile bool         enabled;
} ConsoleSource;

void consoleSourceRegister(ConsoleSource *source);
void consoleSourceFreeze(void);
bool consoleSourceIsEnabled(const ConsoleSource *source);
void consoleSourceSend(const ConsoleSource *source, const char *text, size_t length);
#ifdef UNIT_TEST_MODE
void consoleResetForTest(void);
#endif
#endif

#endif /*CONSOLE_H_*/
