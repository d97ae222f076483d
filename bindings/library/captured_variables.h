/* What captured.h's rows say, as tables over the block of a drone. */
#ifndef CF_LIBRARY_CAPTURED_VARIABLES_H
#define CF_LIBRARY_CAPTURED_VARIABLES_H

#include <stdbool.h>
#include <stddef.h>

#include "library/library.h"

// Reads the rows. Those whose name is in the tables of `inner` already, or came before, are left
// out: the first wins. So are those that no drone has of its own: outside of the image, or of a
// type that no client knows. Returns false when memory ran out. The image must be open.
bool cf_captured_open(const cf_provider_t *inner);

cf_variables_t cf_captured_parameters(void);
cf_variables_t cf_captured_logs(void);

// How many rows were left out because they lie outside of the image or are of no known type.
int cf_captured_dropped(void);

// Size of a cf_type_t [bytes], 0 for a type that no client knows.
size_t cf_captured_size(int type);

// For the drone at work: runs the callback of a parameter, if it has one; the parameter is known by
// its name, or by where it is.
void cf_captured_parameter_written(const char *group, const char *name);
void cf_captured_parameter_set(const void *address);

// For the drone at work: computes the log variables that are functions, all of them, or the one
// whose value is kept at this address, if any is.
void cf_captured_refresh_logs(void);
void cf_captured_refresh_log(const void *address);

#endif  // CF_LIBRARY_CAPTURED_VARIABLES_H
