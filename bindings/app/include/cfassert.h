// The firmware's cfassert.h for apps. A failed assertion stops the drone, and none but this one.
#ifndef CF_APP_CFASSERT_H
#define CF_APP_CFASSERT_H

#include "library/services.h"

#define ASSERT(e) ((e) ? (void)0 : assertFail(#e, __FILE__, __LINE__))
#define ASSERT_FAILED() assertFail("", __FILE__, __LINE__)
#define IF_DEBUG_ASSERT(e)

#endif  // CF_APP_CFASSERT_H
