/* Which drone is at work in this copy of the library, and how a function that fails is left.
 *
 * The functions of the provider table run like this (guard.c):
 *
 *   cf_work_enter(state, "name");           the image of the drone is in place
 *   if ((signal = sigsetjmp(cf_work_rescue, 0)) == 0) {
 *     cf_work_protect();                    from here on a crash comes back to sigsetjmp
 *     ... the function of the inner table
 *     cf_work_leave(state);
 *   } else {
 *     cf_work_abandon(signal);
 *   }
 *
 * The signal mask is not saved, which would cost a system call each time; cf_work_abandon() puts it
 * right when there was a signal. */
#ifndef CF_LIBRARY_WORK_H
#define CF_LIBRARY_WORK_H

#include <setjmp.h>
#include <stdbool.h>
#include <stdint.h>

#include "library/library.h"

extern sigjmp_buf cf_work_rescue;

void cf_work_open(const cf_library_host_t *host);

// What provider.h says: in between, the image of the drone stays in place.
void cf_work_begin(void *state);
void cf_work_end(void *state);

void cf_work_enter(const void *state, const char *function);
// The same for a new drone, with the image as it was when the library was loaded.
void cf_work_enter_factory(void *state, const char *function);
void cf_work_protect(void);
void cf_work_leave(void *state);
// For functions that change nothing.
void cf_work_leave_unchanged(const void *state);
// Tells the host why. Keeps nothing of what the drone did since its image was put in place.
void cf_work_abandon(int signal);

// Tells what runs, for the reason of a failure, in better words than the name of the entry.
void cf_work_on(const char *function);

// Time of the drone at work [ms].
void cf_work_tell_time(uint32_t now_ms);

// A variable of the drone at work, as its distance in bytes from the block, which stays the same
// for as long as there is the drone. Returns false when there is none of that name.
bool cf_work_find(bool is_log, const char *group, const char *name, int32_t *distance, int *type);

// The reverse: group and name of what cf_work_find gave a distance for.
bool cf_work_name(bool is_log, int32_t distance, const char **group, const char **name);

// Where the variable at this distance is now: in the image or with the host.
void *cf_work_variable(int32_t distance);

#endif  // CF_LIBRARY_WORK_H
