/* Stacks for tasks, and the switch between the simulation's stack and one of them.
 *
 * The stacks belong to this copy of the library, not to a drone. What a drone needs of a stack is
 * the slice from its stack pointer to the top, at the time when its task waits. It is taken with
 * cf_coroutine_keep() and comes back with cf_coroutine_resume(), here or on another copy. All words
 * of a slice that look like pointers into the library are kept as distances (relocation.h): return
 * addresses, frame pointers, pointers to variables of the image and to the task's own locals. A
 * number of 8 bytes that happens to lie in this range of some hundred kilobytes would be taken for
 * a pointer; no float and no time of the firmware does.
 *
 * Equal flights have equal slices: what is above the deepest slice is cleared before a task goes
 * on, and the frames of the shim have no gaps. Frames of the firmware have some: the half of a word
 * that a function does not use, such as the padding of a struct, shows half of an address that an
 * earlier one left there. It is never read, but by it images may differ where these halves do:
 * upper halves between processes, and between copies with a multiple of 4 GiB between them; lower
 * halves, which gcc leaves without optimization only, as far as has been seen, between all copies.
 *
 * A slice must hold no canary of the process and no signed address: compile what runs in tasks with
 * -fno-stack-protector, on x86-64 with -fcf-protection=none and on aarch64 with
 * -mbranch-protection=none. */
#ifndef CF_BITCRAZE_RTOS_COROUTINE_H
#define CF_BITCRAZE_RTOS_COROUTINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#define CF_STACKS 8
#define CF_STACK_BYTES 65536
#define CF_SLICE_BYTES 4096  // that a waiting task may use of its stack

// What a fresh stack runs; must not return.
typedef void (*cf_coroutine_main_t)(int number);

// Runs stack `number` until it waits. Goes on with a slice of this many words, or, with none,
// begins with main(number). Returns the bytes that are in use now.
size_t cf_coroutine_resume(int number, const uint64_t *slice, size_t words,
                           cf_coroutine_main_t main);

// Copies the upper `words` of a stack that waits.
void cf_coroutine_keep(int number, uint64_t *slice, size_t words);

// Whether nothing was written behind the low end of a stack.
bool cf_coroutine_is_intact(int number);

// On one of the stacks: goes back to the simulation, returns with the next cf_coroutine_resume().
void cf_coroutine_wait(void);

// Clears what functions that returned left below the caller. Frames have gaps, in which leftovers
// would come into the slice: harmless, but not the same bits in equal flights.
void cf_coroutine_clean(void);

// Number of the stack that the caller runs on, or -1 on the simulation's. A look at the stack
// pointer: there is nothing to put right after a jump out of a task.
int cf_coroutine_number(void);

// On the simulation's stack: forgets the task that was running when it was left by a jump.
void cf_coroutine_abandon(void);

#endif  // CF_BITCRAZE_RTOS_COROUTINE_H
