#include "providers.h"

#include <string.h>

#include "builtin/builtin.h"
#include "loader/library_loader.h"

const cf_provider_t *cf_provider(int i) {
  return i == 0 ? cf_builtin_provider() : cf_library_table(i);
}

int cf_provider_count(void) {
  return 1 + cf_library_count();
}

static bool is_library(int i) {
  return i >= 1 && i <= cf_library_count();
}

const char *cf_provider_name(int i) {
  if (is_library(i)) {
    return cf_library_name(i);
  }
  return i == 0 ? cf_builtin_provider()->name : NULL;
}

int cf_provider_platform(int i) {
  return is_library(i) ? cf_library_platform(i) : -1;
}

int cf_provider_find(const char *name, cf_platform_t platform) {
  return strcmp(name, cf_builtin_provider()->name) == 0 ? 0 : cf_library_find(name, (int)platform);
}

int cf_provider_block_bytes(int i) {
  if (is_library(i)) {
    return cf_library_block_bytes(i);
  }
  return i == 0 ? CF_PROVIDER_STATE_BYTES : 0;
}
