/* How a pointer into the library is kept where other copies of the library will find it.
 *
 * Copies lie at different addresses. A pointer into this one is therefore kept as its distance from
 * the begin of the library, with a mark in the upper 16 bits. No address that a program can have
 * looks like this, and no small number that code stores in a pointer, such as (void *)1:
 * all other values are kept as they are. Null is one of them. So are addresses elsewhere (the C
 * library, the heap), which are the same for all copies of the library. */
#ifndef CF_LIBRARY_RELOCATION_H
#define CF_LIBRARY_RELOCATION_H

#include <stdint.h>

// The linker's names for the first byte of the library in memory and for the one behind the last.
extern char __ehdr_start[] __attribute__((visibility("hidden")));
extern char _end[] __attribute__((visibility("hidden")));

#define CF_RELOCATION_MARK ((uintptr_t)0xCF1B << 48)
#define CF_RELOCATION_MARK_BITS ((uintptr_t)0xFFFF << 48)

static inline uintptr_t cf_library_begin(void) {
  return (uintptr_t)__ehdr_start;
}

static inline uintptr_t cf_library_bytes(void) {
  return (uintptr_t)_end - cf_library_begin();
}

// Neither has branches: in a stack pointers and numbers come in no order that could be foreseen.
static inline uintptr_t cf_to_distance(uintptr_t pointer, uintptr_t begin, uintptr_t bytes) {
  // one behind the last is a pointer of C as well
  const uintptr_t is_inside = pointer - begin <= bytes;
  return pointer + ((CF_RELOCATION_MARK - begin) & -is_inside);
}

static inline uintptr_t cf_to_address(uintptr_t kept, uintptr_t begin) {
  const uintptr_t is_marked = (kept & CF_RELOCATION_MARK_BITS) == CF_RELOCATION_MARK;
  return kept + ((begin - CF_RELOCATION_MARK) & -is_marked);
}

#endif  // CF_LIBRARY_RELOCATION_H
