/* A user's own controller and estimator, by the names of the firmware's app layer
 * (docs/reference/control-geometric.md#3.5).
 *
 * Here is what does not depend on the types of a checkout; controllerOutOfTree(),
 * estimatorOutOfTree() and estimatorDequeue() are the adapter's. */
#ifndef CF_LIBRARY_OUT_OF_TREE_H
#define CF_LIBRARY_OUT_OF_TREE_H

#include <stdbool.h>
#include <stddef.h>

#define CF_OUT_OF_TREE_NAME "OutOfTree"

// Whether the library was linked with such code.
bool cf_out_of_tree_has_controller(void);
bool cf_out_of_tree_has_estimator(void);

// Init, then Test. A false test stops the drone: the vehicle does not leave the ground then.
void cf_out_of_tree_init_controller(void);
void cf_out_of_tree_init_estimator(void);

// What estimatorDequeue() takes from, for as long as one call of the estimator: measurements of
// whatever type, which are the caller's.
void cf_out_of_tree_open_queue(const void *measurements, int count, size_t bytes_of_each);
void cf_out_of_tree_close_queue(void);

// Returns the next measurement, or null when all are taken.
const void *cf_out_of_tree_next(void);

#endif  // CF_LIBRARY_OUT_OF_TREE_H
