#include "library/image.h"

#include <stdlib.h>
#include <string.h>

#include "library/inner.h"
#include "library/relocation.h"

#define WORD 8  // [bytes]

_Static_assert(sizeof(void *) == WORD, "pointers and whole words are of one size");

typedef struct {
  char    *address;
  uint32_t bytes;
  uint32_t at;  // offset in a block
} range_t;

typedef struct {
  char    *address;
  uint32_t at;  // offset in a block
} slot_t;

static range_t *ranges CF_LIBRARY_KEEP = NULL;
static int n_ranges    CF_LIBRARY_KEEP = 0;
static slot_t *slots   CF_LIBRARY_KEEP = NULL;  // of pointers
static int n_slots     CF_LIBRARY_KEEP = 0;
static size_t n_bytes  CF_LIBRARY_KEEP = 0;
static void *factory   CF_LIBRARY_KEEP = NULL;  // a block

// ------------------------------------------------------------------------------------ in and out

// By memcpy, since a packed struct may hold a pointer at any address.
static uintptr_t get_word(const void *from) {
  uintptr_t word;
  memcpy(&word, from, sizeof word);
  return word;
}

static void put_word(void *to, uintptr_t word) {
  memcpy(to, &word, sizeof word);
}

void cf_image_load(const void *block) {
  const char *kept = block;
  for (int i = 0; i < n_ranges; i++) {
    memcpy(ranges[i].address, kept + ranges[i].at, ranges[i].bytes);
  }
  const uintptr_t begin = cf_library_begin();
  for (int i = 0; i < n_slots; i++) {
    put_word(slots[i].address, cf_to_address(get_word(kept + slots[i].at), begin));
  }
}

void cf_image_store(void *block) {
  char *kept = block;
  for (int i = 0; i < n_ranges; i++) {
    memcpy(kept + ranges[i].at, ranges[i].address, ranges[i].bytes);
  }
  const uintptr_t begin = cf_library_begin();
  const uintptr_t bytes = cf_library_bytes();
  for (int i = 0; i < n_slots; i++) {
    put_word(kept + slots[i].at, cf_to_distance(get_word(slots[i].address), begin, bytes));
  }
}

void cf_image_restore_factory(void) {
  cf_image_load(factory);
}

size_t cf_image_bytes(void) {
  return n_bytes;
}

// -------------------------------------------------------------------------------------- addresses

ptrdiff_t cf_image_offset(const void *address, size_t bytes) {
  for (int i = 0; i < n_ranges; i++) {
    const uintptr_t into = (uintptr_t)address - (uintptr_t)ranges[i].address;
    if (into <= ranges[i].bytes && bytes <= ranges[i].bytes - into) {
      return (ptrdiff_t)(ranges[i].at + into);
    }
  }
  return -1;
}

void *cf_image_address(size_t offset) {
  for (int i = 0; i < n_ranges; i++) {
    if (offset - ranges[i].at < ranges[i].bytes) {
      return ranges[i].address + (offset - ranges[i].at);
    }
  }
  return NULL;
}

// ---------------------------------------------------------------------------------------- opening

static bool take_ranges(const cf_image_map_t *map) {
  uint32_t at = 0;
  for (int i = 0; i < map->n_ranges; i++) {
    const cf_image_range_t *range = &map->ranges[i];
    if (range->offset > cf_library_bytes() || range->bytes > cf_library_bytes() - range->offset) {
      return false;
    }
    char *address = __ehdr_start + range->offset;
    at += (uint32_t)((uintptr_t)address - at) % WORD;
    ranges[n_ranges++] = (range_t){.address = address, .bytes = range->bytes, .at = at};
    at += range->bytes;
  }
  n_bytes = (at + WORD - 1) / WORD * WORD;
  return true;
}

static bool take_slots(const cf_image_map_t *map) {
  for (int i = 0; i < map->n_pointers; i++) {
    char           *address = __ehdr_start + map->pointers[i];
    const ptrdiff_t at      = cf_image_offset(address, WORD);
    if (at < 0) {
      return false;
    }
    slots[n_slots++] = (slot_t){.address = address, .at = (uint32_t)at};
  }
  return true;
}

// calloc, and never null for nothing
static void *some(int count, size_t bytes) {
  return calloc(count > 0 ? (size_t)count : 1, bytes);
}

bool cf_image_open(const cf_image_map_t *map) {
  ranges = some(map->n_ranges, sizeof *ranges);
  slots  = some(map->n_pointers, sizeof *slots);
  if (ranges == NULL || slots == NULL || !take_ranges(map) || !take_slots(map)) {
    return false;
  }
  factory = some((int)n_bytes, 1);
  if (factory == NULL) {
    return false;
  }
  cf_image_store(factory);
  return true;
}
