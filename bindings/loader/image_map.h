/* Checks that an image map belongs to a library, and keeps a copy of one. */
#ifndef CF_LOADER_IMAGE_MAP_H
#define CF_LOADER_IMAGE_MAP_H

#include <stdbool.h>

#include "library/library.h"

// What is wrong with a map by itself, as it continues "the image map", or null when ranges ascend
// apart from each other and every pointer lies in one of them.
const char *cf_image_map_fault(const cf_image_map_t *map);

// The same about a map that is right by itself and a library: null when all ranges lie in variables
// that its code may write. `handle` is that of dlopen.
const char *cf_image_map_misfit(const cf_image_map_t *map, void *handle);

// A copy with memory of its own. Returns false when there is none left.
bool cf_image_map_copy(cf_image_map_t *copy, const cf_image_map_t *map);
void cf_image_map_free(cf_image_map_t *copy);

// Whether both say the same.
bool cf_image_map_equals(const cf_image_map_t *a, const cf_image_map_t *b);

#endif  // CF_LOADER_IMAGE_MAP_H
