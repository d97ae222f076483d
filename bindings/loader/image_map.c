#define _GNU_SOURCE  // dlinfo, dl_iterate_phdr
#include "loader/image_map.h"

#include <dlfcn.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#ifdef __linux__

#include <link.h>

// A stretch of the library's memory: is it made of variables that code may write?
typedef struct {
  uintptr_t base;  // of the library
  uint64_t  begin;
  uint64_t  end;
  bool      is_writable;
} stretch_t;

static int look_into(struct dl_phdr_info *info, size_t size, void *context) {
  (void)size;
  stretch_t *stretch = context;
  if (info->dlpi_addr != stretch->base) {
    return 0;
  }
  for (int i = 0; i < info->dlpi_phnum; i++) {
    const ElfW(Phdr) *part = &info->dlpi_phdr[i];
    const uint64_t first   = part->p_vaddr;
    const uint64_t last    = part->p_vaddr + part->p_memsz;
    if (part->p_type == PT_LOAD && (part->p_flags & PF_W) != 0 && stretch->begin >= first &&
        stretch->end <= last) {
      stretch->is_writable = true;
    }
    // what the loader made read-only after it had filled in addresses
    if (part->p_type == PT_GNU_RELRO && stretch->begin < last && stretch->end > first) {
      stretch->is_writable = false;
      return 1;
    }
  }
  return 1;
}

static bool is_variable(void *handle, uint64_t begin, uint64_t end) {
  struct link_map *library;
  if (dlinfo(handle, RTLD_DI_LINKMAP, &library) != 0) {
    return false;  // cannot happen with a handle that is open
  }
  stretch_t stretch = {.base = library->l_addr, .begin = begin, .end = end, .is_writable = false};
  dl_iterate_phdr(look_into, &stretch);
  return stretch.is_writable;
}

#else

static bool is_variable(void *handle, uint64_t begin, uint64_t end) {
  (void)handle;
  return end > begin;
}

#endif

static uint64_t end_of(const cf_image_range_t *range) {
  return (uint64_t)range->offset + range->bytes;
}

static bool is_in_a_range(const cf_image_map_t *map, uint32_t pointer) {
  for (int i = 0; i < map->n_ranges; i++) {
    if (pointer >= map->ranges[i].offset &&
        (uint64_t)pointer + sizeof(void *) <= end_of(&map->ranges[i])) {
      return true;
    }
  }
  return false;
}

const char *cf_image_map_fault(const cf_image_map_t *map) {
  if (map->n_ranges < 0 || map->n_pointers < 0 || (map->n_ranges > 0 && map->ranges == NULL) ||
      (map->n_pointers > 0 && map->pointers == NULL)) {
    return "has a negative count or no list";
  }
  uint64_t free_from = 0;
  for (int i = 0; i < map->n_ranges; i++) {
    const cf_image_range_t *range = &map->ranges[i];
    if (range->bytes == 0 || range->offset < free_from) {
      return "has ranges that are empty, overlap or do not ascend";
    }
    free_from = end_of(range);
  }
  for (int i = 0; i < map->n_pointers; i++) {
    if (!is_in_a_range(map, map->pointers[i])) {
      return "has a pointer outside its ranges";
    }
  }
  return NULL;
}

const char *cf_image_map_misfit(const cf_image_map_t *map, void *handle) {
  for (int i = 0; i < map->n_ranges; i++) {
    if (!is_variable(handle, map->ranges[i].offset, end_of(&map->ranges[i]))) {
      return "has a range outside the library's variables";
    }
  }
  return NULL;
}

static void *duplicate(const void *list, size_t bytes) {
  void *copy = malloc(bytes > 0 ? bytes : 1);
  if (copy != NULL && bytes > 0) {
    memcpy(copy, list, bytes);
  }
  return copy;
}

static size_t bytes_of_ranges(const cf_image_map_t *map) {
  return (size_t)map->n_ranges * sizeof *map->ranges;
}

static size_t bytes_of_pointers(const cf_image_map_t *map) {
  return (size_t)map->n_pointers * sizeof *map->pointers;
}

bool cf_image_map_copy(cf_image_map_t *copy, const cf_image_map_t *map) {
  copy->n_ranges   = map->n_ranges;
  copy->n_pointers = map->n_pointers;
  copy->ranges     = duplicate(map->ranges, bytes_of_ranges(map));
  copy->pointers   = duplicate(map->pointers, bytes_of_pointers(map));
  return copy->ranges != NULL && copy->pointers != NULL;
}

void cf_image_map_free(cf_image_map_t *copy) {
  free((void *)(uintptr_t)copy->ranges);
  free((void *)(uintptr_t)copy->pointers);
}

static bool are_equal(const void *a, const void *b, size_t bytes) {
  return bytes == 0 || memcmp(a, b, bytes) == 0;
}

bool cf_image_map_equals(const cf_image_map_t *a, const cf_image_map_t *b) {
  return a->n_ranges == b->n_ranges && a->n_pointers == b->n_pointers &&
         are_equal(a->ranges, b->ranges, bytes_of_ranges(a)) &&
         are_equal(a->pointers, b->pointers, bytes_of_pointers(a));
}
