#define _GNU_SOURCE  // sysconf, mprotect
#include "bitcraze/rtos/coroutine.h"

#include <sys/mman.h>
#include <unistd.h>

#include "library/inner.h"
#include "library/relocation.h"

#if defined(__ARM_FEATURE_PAC_DEFAULT)
#error "signed return addresses cannot go to another stack: compile with -mbranch-protection=none"
#endif

#define WORD 8             // [bytes]
#define CANARY_WORDS 8     // above the guard page
#define CLEAN_BYTES 320    // more than the frames from a call of the shim to the switch
#define LARGEST_PAGE 4096  // [bytes] of a guard, so that enough is left of a stack

// ---------------------------------------------------------------------------------------- switch

// cf_switch_stacks(&old, new) keeps the registers that a function must preserve on the stack in
// use, stores its stack pointer in `old` and goes on where `new` was left by the same function.
// What else is in registers is cleared, so that no leftovers of one drone get on another's stack.
// cf_coroutine_first() is where a fresh stack begins, with the number of the stack in the first
// register that is preserved. The rounding mode is the same everywhere.
void cf_switch_stacks(void **old, void *new);
void cf_coroutine_first(void);
void cf_coroutine_begin(int number) __attribute__((visibility("hidden"), used));

#if defined(__x86_64__)
// from the stack pointer up: r15, r14, r13, r12, rbx, rbp, return address
#define SAVED_NUMBER 4
#define SAVED_RETURN 6
#define FRESH_WORDS 7
__asm__(
    ".pushsection .text\n"
    ".hidden cf_switch_stacks\n"
    ".globl cf_switch_stacks\n"
    ".type cf_switch_stacks, %function\n"
    "cf_switch_stacks:\n"
    "  pushq %rbp\n  pushq %rbx\n  pushq %r12\n  pushq %r13\n  pushq %r14\n  pushq %r15\n"
    "  movq %rsp, (%rdi)\n"
    "  movq %rsi, %rsp\n"
    "  popq %r15\n  popq %r14\n  popq %r13\n  popq %r12\n  popq %rbx\n  popq %rbp\n"
    "  xorl %eax, %eax\n  xorl %ecx, %ecx\n  xorl %edx, %edx\n  xorl %esi, %esi\n"
    "  xorl %edi, %edi\n  xorl %r8d, %r8d\n  xorl %r9d, %r9d\n  xorl %r10d, %r10d\n"
    "  xorl %r11d, %r11d\n"
    "  ret\n"
    ".size cf_switch_stacks, . - cf_switch_stacks\n"
    ".hidden cf_coroutine_first\n"
    ".globl cf_coroutine_first\n"
    ".type cf_coroutine_first, %function\n"
    "cf_coroutine_first:\n"
    "  .cfi_startproc\n  .cfi_undefined rip\n"  // no caller
    "  movl %ebx, %edi\n"
    "  xorl %ebx, %ebx\n"
    "  call cf_coroutine_begin\n"
    "  ud2\n"
    "  .cfi_endproc\n"
    ".size cf_coroutine_first, . - cf_coroutine_first\n"
    ".popsection\n");
#elif defined(__aarch64__)
// from the stack pointer up: x19 to x28, x29, x30, d8 to d15
#define SAVED_NUMBER 0
#define SAVED_RETURN 11
#define FRESH_WORDS 20
__asm__(
    ".pushsection .text\n"
    ".hidden cf_switch_stacks\n"
    ".globl cf_switch_stacks\n"
    ".type cf_switch_stacks, %function\n"
    "cf_switch_stacks:\n"
    "  sub sp, sp, #160\n"
    "  stp x19, x20, [sp]\n  stp x21, x22, [sp, #16]\n  stp x23, x24, [sp, #32]\n"
    "  stp x25, x26, [sp, #48]\n  stp x27, x28, [sp, #64]\n  stp x29, x30, [sp, #80]\n"
    "  stp d8, d9, [sp, #96]\n  stp d10, d11, [sp, #112]\n"
    "  stp d12, d13, [sp, #128]\n  stp d14, d15, [sp, #144]\n"
    "  mov x9, sp\n"
    "  str x9, [x0]\n"
    "  mov sp, x1\n"
    "  ldp x19, x20, [sp]\n  ldp x21, x22, [sp, #16]\n  ldp x23, x24, [sp, #32]\n"
    "  ldp x25, x26, [sp, #48]\n  ldp x27, x28, [sp, #64]\n  ldp x29, x30, [sp, #80]\n"
    "  ldp d8, d9, [sp, #96]\n  ldp d10, d11, [sp, #112]\n"
    "  ldp d12, d13, [sp, #128]\n  ldp d14, d15, [sp, #144]\n"
    "  add sp, sp, #160\n"
    "  mov x0, #0\n  mov x1, #0\n  mov x2, #0\n  mov x3, #0\n"
    "  mov x8, #0\n  mov x9, #0\n  mov x10, #0\n  mov x11, #0\n"
    "  ret\n"
    ".size cf_switch_stacks, . - cf_switch_stacks\n"
    ".hidden cf_coroutine_first\n"
    ".globl cf_coroutine_first\n"
    ".type cf_coroutine_first, %function\n"
    "cf_coroutine_first:\n"
    "  .cfi_startproc\n  .cfi_undefined x30\n"  // no caller
    "  mov x0, x19\n"
    "  mov x19, #0\n"
    "  mov x30, #0\n"
    "  bl cf_coroutine_begin\n"
    "  brk #1\n"
    "  .cfi_endproc\n"
    ".size cf_coroutine_first, . - cf_coroutine_first\n"
    ".popsection\n");
#else
#error "tasks of the firmware run on x86-64 and on aarch64"
#endif

// ---------------------------------------------------------------------------------------- stacks

// A section of its own, which takes no room in the file: no variables of a drone. Aligned such that
// what is aligned on one copy of the library is aligned on every other.
__asm__(
    ".pushsection .cf_stacks, \"aw\", %nobits\n"
    ".balign 4096\n"
    ".hidden cf_stacks\n"
    ".globl cf_stacks\n"
    ".type cf_stacks, %object\n"
    "cf_stacks:\n"
    ".zero 524288\n"
    ".size cf_stacks, 524288\n"
    ".popsection\n");
extern uint64_t cf_stacks[CF_STACKS][CF_STACK_BYTES / WORD]
    __attribute__((visibility("hidden"), aligned(4096)));
_Static_assert(sizeof cf_stacks == 524288, "the assembler gets the size as a number");

static void *of_simulation CF_LIBRARY_KEEP = NULL;  // stack pointer while suspended
static void *of_task       CF_LIBRARY_KEEP = NULL;
static bool is_guarded     CF_LIBRARY_KEEP = false;

static cf_coroutine_main_t main_of_task CF_LIBRARY_KEEP = NULL;

static const uint64_t CANARY = 0x5AFE57AC0FF1C1A1u;

static uint64_t *canary(int number) {
  return cf_stacks[number] + LARGEST_PAGE / WORD;
}

static uint64_t *top(int number) {
  return cf_stacks[number] + CF_STACK_BYTES / WORD;
}

// Makes the lowest page of each stack read-only: endless recursion crashes there instead of
// overwriting other data of the library. Leak checkers may read the page.
static void guard(void) {
  const long page = sysconf(_SC_PAGESIZE);
  for (int i = 0; i < CF_STACKS && page > 0 && page <= LARGEST_PAGE; i++) {
    // without, there is the canary still
    (void)mprotect(cf_stacks[i], (size_t)page, PROT_READ);
  }
  is_guarded = true;
}

int cf_coroutine_number(void) {
  const uintptr_t into = (uintptr_t)__builtin_frame_address(0) - (uintptr_t)cf_stacks;
  return into < sizeof cf_stacks ? (int)(into / CF_STACK_BYTES) : -1;
}

bool cf_coroutine_is_intact(int number) {
  for (int i = 0; i < CANARY_WORDS; i++) {
    if (canary(number)[i] != CANARY) {
      return false;
    }
  }
  return true;
}

// ------------------------------------------------------------------------------------- sanitizer

// AddressSanitizer wants to know which stack is in use, and marks what functions must not touch.
#ifdef __SANITIZE_ADDRESS__
#include <sanitizer/asan_interface.h>
#include <sanitizer/common_interface_defs.h>
#define UNCHECKED __attribute__((no_sanitize_address, noinline))

static const void *simulation_low CF_LIBRARY_KEEP = NULL;
static size_t simulation_bytes    CF_LIBRARY_KEEP = 0;
static bool is_away               CF_LIBRARY_KEEP = false;

static void will_enter(int number, void **fake) {
  __asan_unpoison_memory_region(cf_stacks[number], sizeof cf_stacks[number]);
  __sanitizer_start_switch_fiber(fake, cf_stacks[number], sizeof cf_stacks[number]);
  is_away = true;
}

static void has_left(void *fake) {
  __sanitizer_finish_switch_fiber(fake, NULL, NULL);
  is_away = false;
}

static void has_entered(void *fake) {
  __sanitizer_finish_switch_fiber(fake, &simulation_low, &simulation_bytes);
}

static void will_leave(void **fake) {
  __sanitizer_start_switch_fiber(fake, simulation_low, simulation_bytes);
}

void cf_coroutine_abandon(void) {
  if (is_away) {
    will_leave(NULL);
    has_left(NULL);
  }
}
#else
#define UNCHECKED
#define will_enter(number_, fake_) ((void)(fake_))
#define has_left(fake_) ((void)(fake_))
#define has_entered(fake_) ((void)(fake_))
#define will_leave(fake_) ((void)(fake_))

void cf_coroutine_abandon(void) {
}
#endif

// ------------------------------------------------------------------------------- in, out and back

// What could come into a slice later must not be what another drone left there.
UNCHECKED static void put_slice(int number, const uint64_t *slice, size_t words) {
  uint64_t *to = top(number) - words;
  for (uint64_t *word = top(number) - CF_SLICE_BYTES / WORD; word < to; word++) {
    *word = 0;
  }
  const uintptr_t begin = cf_library_begin();
  for (size_t i = 0; i < words; i++) {
    to[i] = cf_to_address(slice[i], begin);
  }
}

static size_t put_fresh(int number) {
  put_slice(number, NULL, 0);
  uint64_t *from     = top(number) - FRESH_WORDS;
  from[SAVED_NUMBER] = (uint64_t)number;
  from[SAVED_RETURN] = (uintptr_t)cf_coroutine_first;
  return FRESH_WORDS;
}

UNCHECKED void cf_coroutine_keep(int number, uint64_t *slice, size_t words) {
  const uint64_t *from  = top(number) - words;
  const uintptr_t begin = cf_library_begin();
  const uintptr_t bytes = cf_library_bytes();
  for (size_t i = 0; i < words; i++) {
    slice[i] = cf_to_distance(from[i], begin, bytes);
  }
}

void cf_coroutine_begin(int number) {
  has_entered(NULL);
  main_of_task(number);
}

size_t cf_coroutine_resume(int number, const uint64_t *slice, size_t words,
                           cf_coroutine_main_t main) {
  if (!is_guarded) {
    guard();
  }
  for (int i = 0; i < CANARY_WORDS; i++) {
    canary(number)[i] = CANARY;
  }
  main_of_task = main;
  void *fake   = NULL;
  will_enter(number, &fake);
  if (words > 0) {
    put_slice(number, slice, words);
  } else {
    words = put_fresh(number);
  }
  cf_switch_stacks(&of_simulation, top(number) - words);
  has_left(fake);
  return (size_t)((char *)top(number) - (char *)of_task);
}

__attribute__((noinline)) void cf_coroutine_clean(void) {
  // one by one: for so few bytes faster than memset()
  volatile uint64_t below[CLEAN_BYTES / WORD];
  for (int i = 0; i < CLEAN_BYTES / WORD; i++) {
    below[i] = 0;
  }
  (void)below;
}

void cf_coroutine_wait(void) {
  void *fake = NULL;
  will_leave(&fake);
  cf_switch_stacks(&of_task, of_simulation);
  has_entered(fake);
}
