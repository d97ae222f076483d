#include "log_copying.h"

#include <string.h>

void cf_log_copy(const cf_t *first, int count, ptrdiff_t stride, const cf_log_stretch_t *stretches,
                 int stretch_count, uint8_t *to) {
  for (int i = 0; i < count; i++) {
    const char *drone = (const char *)first + i * stride;
    for (int k = 0; k < stretch_count; k++) {
      memcpy(to, drone + stretches[k].offset, stretches[k].bytes);
      to += stretches[k].bytes;
    }
  }
}
