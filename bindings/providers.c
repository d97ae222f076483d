// Which providers this build has.

#include "builtin/builtin.h"
#include "provider.h"

const cf_provider_t *cf_provider(int i) {
  return i == 0 ? cf_builtin_provider() : NULL;
}
