// Prints for developers. Has no guard: each inclusion looks at the macros again.
// clang-format off
#include "config.h"
#include "console.h"
// clang-format on

#ifdef CONFIG_DEBUG_PRINT_ON_UART1
#include "uart1.h"
#endif
#ifdef DEBUG_PRINT_ON_SEGGER_RTT
#include "SEGGER_RTT.h"
#endif

#ifdef DEBUG_MODULE
#define DEBUG_FMT(fmt) DEBUG_MODULE ": " fmt
#endif

#ifndef DEBUG_FMT
#define DEBUG_FMT(fmt) fmt
#endif

void debugInit(void);

#if defined(UNIT_TEST_MODE)
#define DEBUG_PRINT(fmt, ...)
#define DEBUG_PRINT_OS(fmt, ...)
#elif defined(CONFIG_DEBUG_PRINT_ON_UART1)
#define DEBUG_PRINT(fmt, ...) uart1Printf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#define DEBUG_PRINT_OS(fmt, ...) uart1Printf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#elif defined(DEBUG_PRINT_ON_SWO)
#define DEBUG_PRINT(fmt, ...) eprintf(ITM_SendChar, fmt, ##__VA_ARGS__)
#define DEBUG_PRINT_OS(fmt, ...) eprintf(ITM_SendChar, fmt, ##__VA_ARGS__)
#elif defined(DEBUG_PRINT_ON_SEGGER_RTT)
#define DEBUG_PRINT(fmt, ...) SEGGER_RTT_printf(0, fmt, ##__VA_ARGS__)
#define DEBUG_PRINT_OS(fmt, ...) SEGGER_RTT_printf(0, fmt, ##__VA_ARGS__)
#else
#define DEBUG_PRINT(fmt, ...) consolePrintf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#define DEBUG_PRINT_OS(fmt, ...) consolePrintf(DEBUG_FMT(fmt), ##__VA_ARGS__)
#endif

#ifndef PRINT_OS_DEBUG_INFO
#undef DEBUG_PRINT_OS
#define DEBUG_PRINT_OS(fmt, ...)
#endif

#ifdef TEST_PRINTS
#define TEST_AND_PRINT(e, msgOK, msgFail) \
  if (e) {                                \
    DEBUG_PRINT(msgOK);                   \
  } else {                                \
    DEBUG_PRINT(msgFail);                 \
  }
#define FAIL_PRINT(msg) DEBUG_PRINT(msg)
#else
#define TEST_AND_PRINT(e, msgOK, msgFail)
#define FAIL_PRINT(msg)
#endif
