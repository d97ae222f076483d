/* When code of a provider library crashes, its thread goes on somewhere safe.
 *
 * A crash is one of the signals SIGSEGV, SIGBUS, SIGFPE, SIGILL and SIGTRAP, or SIGABRT, by which
 * assert() ends. Earlier handlers still get those that are not ours. */
#ifndef CF_LOADER_RESCUE_H
#define CF_LOADER_RESCUE_H

// Installs the handlers of the process, once.
void cf_rescue_install(void);

// Gives this thread a stack on which it can be rescued when its own has run out, unless it has one
// already; and takes it back. To be called in pairs by one thread.
void cf_rescue_enter_thread(void);
void cf_rescue_leave_thread(void);

// Where siglongjmp goes, with the number of the signal, when this thread crashes: a sigjmp_buf *.
// Null: nowhere.
void cf_rescue_set(void *rescue);

#endif  // CF_LOADER_RESCUE_H
