#ifndef CONSOLE_H_
#define CONSOLE_H_

#include "eprintf.h"

int  consolePutchar(int ch);
void consoleFlush(void);

#define consolePrintf(FMT, ...) eprintf(consolePutchar, FMT, ##__VA_ARGS__)

#endif  // CONSOLE_H_
