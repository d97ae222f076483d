// Assertions that stop the vehicle.
// clang-format off: one of them warns on a host
#if MINIATURE_RELEASE >= 202502
#include "stm32fxxx.h"
#endif
#include "console.h"
// clang-format on

#ifndef __CFASSERT_H__
#define __CFASSERT_H__

#define ASSERT(e) \
  if (e)          \
    ;             \
  else            \
    assertFail(#e, __FILE__, __LINE__)

#ifdef DEBUG
#define IF_DEBUG_ASSERT(e) ASSERT(e)
#else
#define IF_DEBUG_ASSERT(e)
#endif

#define ASSERT_FAILED() assertFail("", __FILE__, __LINE__)
#if MINIATURE_RELEASE >= 202502

// DMA does not reach the core-coupled memory
#ifdef STM32F4XX
#define ASSERT_DMA_SAFE(PTR) \
  ASSERT(((uint32_t)(PTR) < 0x10000000) || ((uint32_t)(PTR) > 0x1000FFFF))
#else
#define ASSERT_DMA_SAFE(PTR)
#endif
#endif

void assertFail(char *exp, char *file, int line);
void printAssertSnapshotData();
#if MINIATURE_RELEASE >= 202502
void storeAssertFileData(const char *file, int line);
void storeAssertHardfaultData(unsigned int r0, unsigned int r1, unsigned int r2, unsigned int r3,
                              unsigned int r12, unsigned int lr, unsigned int pc, unsigned int psr);
void storeAssertTextData(const char *text);
bool cfAssertNormalStartTest(void);
#else
void storeAssertSnapshotData(const char *file, int line);
#endif

#endif  // __CFASSERT_H__
