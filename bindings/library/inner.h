/* What an adapter gives to the rest of a provider library, inside of it.
 *
 * The rest (entry, image, guard, captured variables) is the same for every adapter. It calls the
 * functions of the inner table with the image of the right drone in place, so that they ignore
 * `state` and work on file-scope variables. `parameters` and `logs` may be null: captured.h tells
 * what PARAM_* and LOG_* declared. */
#ifndef CF_LIBRARY_INNER_H
#define CF_LIBRARY_INNER_H

#include "library/library.h"

// For variables of the library itself: they are no part of the image.
#define CF_LIBRARY_KEEP __attribute__((section(".cf_keep")))

// The adapter's table.
const cf_provider_t *cf_library_inner(void);

// For adapters, while one of their functions runs. Prints on the console of the drone at work.
void cf_library_print(const char *text);

// Ends the function that runs and stops the drone at work; does not return.
_Noreturn void cf_library_fail(const char *reason);

// Time of the drone at work [ms], as passed to the latest function that takes a time.
uint32_t cf_library_now_ms(void);

// Address of a variable of the drone at work, wherever it lives, and its cf_type_t, or null.
void *cf_library_variable(int is_log, const char *group, const char *name, int *type);

#endif  // CF_LIBRARY_INNER_H
