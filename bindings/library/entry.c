/* The door of a provider library: everything else in it is hidden. */
#include "library/captured_variables.h"
#include "library/guard.h"
#include "library/image.h"
#include "library/inner.h"

__attribute__((visibility("default"))) const cf_provider_t *cf_library_open(
    int abi, const cf_library_host_t *host, const cf_image_map_t *map);

const cf_provider_t *cf_library_open(int abi, const cf_library_host_t *host,
                                     const cf_image_map_t *map) {
  // the image first: it is kept as the code finds it on a vehicle that was just switched on
  if (abi != CF_LIBRARY_ABI || !cf_image_open(map) || !cf_captured_open(cf_library_inner())) {
    return NULL;
  }
  return cf_guard_open(host);
}
