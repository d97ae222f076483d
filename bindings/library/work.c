// With it longjmp() ends a process that jumps from one stack to another, as out of a task.
#undef _FORTIFY_SOURCE

#include "library/work.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>

#include "library/image.h"
#include "library/inner.h"

#define ASSERTION (-1)  // instead of the number of a signal

sigjmp_buf cf_work_rescue CF_LIBRARY_KEEP;

static const cf_library_host_t *host CF_LIBRARY_KEEP = NULL;
static void *owner                   CF_LIBRARY_KEEP = NULL;  // between begin and end
static void *drone                   CF_LIBRARY_KEEP = NULL;  // while a function runs
static const char *running           CF_LIBRARY_KEEP = NULL;  // the name of that function
static char                          reason[256] CF_LIBRARY_KEEP = "";

// part of the image: every drone has its own time
static uint32_t latest_ms;

void cf_work_open(const cf_library_host_t *of_library) {
  host = of_library;
}

// ------------------------------------------------------------------------- whose image is in place

// An owner that never came to its end is forgotten: its block may be gone by now.
void cf_work_begin(void *state) {
  cf_image_load(state);
  owner = state;
}

void cf_work_end(void *state) {
  // after a failure the image has no owner any more
  if (owner == state) {
    cf_image_store(state);
    owner = NULL;
  }
}

// Makes room for another drone, should one come between begin and end.
static void put_owner_away(const void *state) {
  if (owner != NULL && owner != state) {
    cf_image_store(owner);
  }
}

static void bring_owner_back(const void *state) {
  if (owner != NULL && owner != state) {
    cf_image_load(owner);
  }
}

// ------------------------------------------------------------------------------------- a function

static void set_to_work(const void *state, const char *function) {
  // a function that promises not to change the state is still at work for it
  drone   = (void *)(uintptr_t)state;
  running = function;
}

void cf_work_enter(const void *state, const char *function) {
  if (owner != state) {
    put_owner_away(state);
    cf_image_load(state);
  }
  set_to_work(state, function);
}

void cf_work_enter_factory(void *state, const char *function) {
  put_owner_away(state);
  cf_image_restore_factory();
  // the caller allocated the block without initializing it: write it even if the function fails
  cf_image_store(state);
  set_to_work(state, function);
}

void cf_work_protect(void) {
  host->set_rescue(&cf_work_rescue);
}

void cf_work_leave(void *state) {
  host->set_rescue(NULL);
  drone = NULL;
  if (owner != state) {
    cf_image_store(state);
    bring_owner_back(state);
  }
}

void cf_work_leave_unchanged(const void *state) {
  host->set_rescue(NULL);
  drone = NULL;
  bring_owner_back(state);
}

void cf_work_on(const char *function) {
  running = function;
}

void cf_work_tell_time(uint32_t now_ms) {
  latest_ms = now_ms;
}

// ---------------------------------------------------------------------------------------- failure

static const char *signal_text(int signal) {
  switch (signal) {
    case SIGSEGV:
      return "segmentation fault";
    case SIGBUS:
      return "bus error";
    case SIGFPE:
      return "division by zero";  // of integers; divisions of floats raise no signal
    case SIGILL:
      return "illegal instruction";
    case SIGABRT:
      return "abort";
    case SIGTRAP:
      return "trap";
    default:
      return "crash";
  }
}

// The handler did not return, so that its signal is still blocked in this thread.
static void unblock(int signal) {
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, signal);
  pthread_sigmask(SIG_UNBLOCK, &set, NULL);
}

// The image was left in the middle of something, so it is dropped: the block stays as it was when
// the function, or the tick, began. What ran well since then is lost with it; the drone flies no
// more anyway, and its block can be read, and its functions called, without a second surprise.
void cf_work_abandon(int signal) {
  host->set_rescue(NULL);
  if (signal != ASSERTION) {
    unblock(signal);
    snprintf(reason, sizeof reason, "%s in %s", signal_text(signal), running);
  }
  void *failed = drone;
  drone        = NULL;
  if (owner == failed) {
    owner = NULL;
  }
  bring_owner_back(failed);
  host->fail(failed, reason);
}

void cf_library_fail(const char *why) {
  if (drone == NULL) {
    // no drone to stop, and no way back
    fprintf(stderr, "%s\n", why);
    abort();
  }
  snprintf(reason, sizeof reason, "%s", why);
  siglongjmp(cf_work_rescue, ASSERTION);
}

// ----------------------------------------------------------------------------- for the code inside

void cf_library_print(const char *text) {
  if (drone != NULL) {
    host->console(drone, text);
  }
}

uint32_t cf_library_now_ms(void) {
  return latest_ms;
}

bool cf_work_find(bool is_log, const char *group, const char *name, int32_t *distance, int *type) {
  if (drone == NULL) {
    return false;
  }
  const char *address = is_log ? host->log_variable(drone, group, name, type)
                               : host->parameter(drone, group, name, type);
  if (address == NULL) {
    return false;
  }
  *distance = (int32_t)((intptr_t)address - (intptr_t)drone);
  return true;
}

bool cf_work_name(bool is_log, int32_t distance, const char **group, const char **name) {
  return drone != NULL && host->name_of(drone, is_log, (char *)drone + distance, group, name);
}

void *cf_work_variable(int32_t distance) {
  void *in_image = distance >= 0 && drone != NULL && (size_t)distance < cf_image_bytes()
                       ? cf_image_address((size_t)distance)
                       : NULL;
  return in_image != NULL ? in_image : (char *)drone + distance;
}

void *cf_library_variable(int is_log, const char *group, const char *name, int *type) {
  int32_t distance;
  return cf_work_find(is_log != 0, group, name, &distance, type) ? cf_work_variable(distance)
                                                                 : NULL;
}
