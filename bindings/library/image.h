/* The image of a drone: all file-scope variables of the library, and the block that keeps them
 * while another drone is at work.
 *
 * A block holds the ranges of the image map one behind the other. Each begins at an offset that
 * equals its address modulo 8, so that what is aligned in memory is aligned in a block. */
#ifndef CF_LIBRARY_IMAGE_H
#define CF_LIBRARY_IMAGE_H

#include <stdbool.h>
#include <stddef.h>

#include "library/library.h"

// Learns the map and keeps the image as it is now, right after the library was loaded. Returns
// false when the map is not one of this library, or when memory ran out.
bool cf_image_open(const cf_image_map_t *map);

// Size of a block, whole words of 8.
size_t cf_image_bytes(void);

// Block to memory, and memory to block. What lies between the ranges of a block stays as it is.
void cf_image_load(const void *block);
void cf_image_store(void *block);

// The image as it was when the library was opened.
void cf_image_restore_factory(void);

// Returns where a block keeps the `bytes` from this address on, or -1 when they are no part of the
// image.
ptrdiff_t cf_image_offset(const void *address, size_t bytes);

// Returns the address of what a block keeps at this offset, or null when it keeps nothing there.
void *cf_image_address(size_t offset);

#endif  // CF_LIBRARY_IMAGE_H
