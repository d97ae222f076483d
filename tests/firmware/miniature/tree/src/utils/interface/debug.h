#include "config.h"
#include "console.h"

#ifdef DEBUG_MODULE
#define DEBUG_FMT(fmt) DEBUG_MODULE ": " fmt
#endif
#ifndef DEBUG_FMT
#define DEBUG_FMT(fmt) fmt
#endif

#ifdef UNIT_TEST_MODE
#define DEBUG_PRINT(fmt, ...)
#else
#define DEBUG_PRINT(fmt, ...) consolePrintf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#endif
