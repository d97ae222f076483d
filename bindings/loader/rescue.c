#define _GNU_SOURCE  // sigaltstack
#include "loader/rescue.h"

#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stddef.h>
#include <stdlib.h>

#define STACK_BYTES 65536

static const int SIGNALS[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGABRT};

#define SIGNAL_COUNT (sizeof SIGNALS / sizeof SIGNALS[0])

// A handler may only touch what is in place already. By default the variables of a thread are made
// when it first asks for them, which allocates.
#ifdef __GLIBC__
#define IN_PLACE __attribute__((tls_model("initial-exec")))
#else
#define IN_PLACE
#endif

static _Thread_local sigjmp_buf *rescue IN_PLACE;
static _Thread_local void              *own_stack;

static struct sigaction previous[SIGNAL_COUNT];

// As if we had never been there. With the system's own handler in place again a fault happens a
// second time when we return, and ends the process where it began; a signal that was sent does not.
// Coverage does not see what leads to the end of a process.
static void hand_on(const struct sigaction *action, int signal, siginfo_t *info, void *context) {
  if ((action->sa_flags & SA_SIGINFO) != 0) {
    action->sa_sigaction(signal, info, context);
  } else if (action->sa_handler == SIG_DFL || action->sa_handler == SIG_IGN) {
    sigaction(signal, action, NULL);
    if (info->si_code <= 0) {
      raise(signal);
    }
  } else {
    action->sa_handler(signal);
  }
}

static void handle(int signal, siginfo_t *info, void *context) {
  sigjmp_buf *way_out = rescue;
  if (way_out != NULL) {
    rescue = NULL;  // a crash on the way out is not caught
    siglongjmp(*way_out, signal);
  }
  for (size_t i = 0; i < SIGNAL_COUNT; i++) {
    if (SIGNALS[i] == signal) {
      hand_on(&previous[i], signal, info, context);
    }
  }
}

static void install(void) {
  for (size_t i = 0; i < SIGNAL_COUNT; i++) {
    struct sigaction action = {.sa_flags = SA_SIGINFO | SA_NODEFER | SA_ONSTACK};
    action.sa_sigaction     = handle;
    sigemptyset(&action.sa_mask);
    sigaction(SIGNALS[i], &action, &previous[i]);
  }
}

void cf_rescue_install(void) {
  static pthread_once_t once = PTHREAD_ONCE_INIT;
  pthread_once(&once, install);
}

void cf_rescue_enter_thread(void) {
  stack_t present;
  if (sigaltstack(NULL, &present) != 0 || (present.ss_flags & SS_DISABLE) == 0) {
    return;
  }
  own_stack = malloc(STACK_BYTES);
  if (own_stack != NULL) {
    const stack_t stack = {.ss_sp = own_stack, .ss_size = STACK_BYTES};
    sigaltstack(&stack, NULL);
  }
}

void cf_rescue_leave_thread(void) {
  stack_t present;
  if (own_stack != NULL && sigaltstack(NULL, &present) == 0 && present.ss_sp == own_stack) {
    const stack_t none = {.ss_flags = SS_DISABLE};
    sigaltstack(&none, NULL);
    free(own_stack);
    own_stack = NULL;
  }
}

void cf_rescue_set(void *buffer) {
  rescue = buffer;
}
