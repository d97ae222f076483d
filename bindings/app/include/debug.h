/* The firmware's debug.h for apps: DEBUG_PRINT writes "NAME: text" to the console of the drone,
 * where NAME is the DEBUG_MODULE that was defined before this header was included. */
#ifndef CF_APP_DEBUG_H
#define CF_APP_DEBUG_H

#include "library/services.h"

#ifdef DEBUG_MODULE
#define DEBUG_FMT(fmt) DEBUG_MODULE ": " fmt
#else
#define DEBUG_FMT(fmt) fmt
#endif

#define DEBUG_PRINT(fmt, ...) consolePrintf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#define DEBUG_PRINT_OS(fmt, ...) DEBUG_PRINT(fmt, ##__VA_ARGS__)

#endif  // CF_APP_DEBUG_H
