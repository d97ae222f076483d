#ifndef CFASSERT_H_
#define CFASSERT_H_

#include "console.h"

#define ASSERT(e)                       \
  if (e) {                              \
  } else {                              \
    assertFail(#e, __FILE__, __LINE__); \
  }

#define ASSERT_FAILED() assertFail("", __FILE__, __LINE__)

void assertFail(char *exp, char *file, int line);

#endif  // CFASSERT_H_
