#include "build_info.h"

#ifndef CF_BUILD_FLAGS
#define CF_BUILD_FLAGS "unknown"
#endif

const char *cf_build_compiler(void) {
#if defined(__clang__)
  return "clang " __clang_version__;
#elif defined(__GNUC__)
  return "gcc " __VERSION__;
#else
  return "unknown compiler";
#endif
}

const char *cf_build_flags(void) {
  return CF_BUILD_FLAGS;
}
