#include "library/out_of_tree.h"

#include "library/inner.h"
#include "library/work.h"

#define MAYBE __attribute__((weak))  // null where the library was linked without

void controllerOutOfTreeInit(void) MAYBE;
bool controllerOutOfTreeTest(void) MAYBE;
void estimatorOutOfTreeInit(void) MAYBE;
bool estimatorOutOfTreeTest(void) MAYBE;

bool cf_out_of_tree_has_controller(void) {
  return controllerOutOfTreeInit != NULL;
}

bool cf_out_of_tree_has_estimator(void) {
  return estimatorOutOfTreeInit != NULL;
}

void cf_out_of_tree_init_controller(void) {
  cf_work_on("controllerOutOfTreeInit");
  controllerOutOfTreeInit();
  cf_work_on("controllerOutOfTreeTest");
  if (controllerOutOfTreeTest != NULL && !controllerOutOfTreeTest()) {
    cf_library_fail("controllerOutOfTreeTest returned false");
  }
}

void cf_out_of_tree_init_estimator(void) {
  cf_work_on("estimatorOutOfTreeInit");
  estimatorOutOfTreeInit();
  cf_work_on("estimatorOutOfTreeTest");
  if (estimatorOutOfTreeTest != NULL && !estimatorOutOfTreeTest()) {
    cf_library_fail("estimatorOutOfTreeTest returned false");
  }
}

// ------------------------------------------------------------------------------------------ queue

// no part of the image: it is the caller's, and gone when the call is over
static const char *next  CF_LIBRARY_KEEP = NULL;
static int left          CF_LIBRARY_KEEP = 0;
static size_t each_bytes CF_LIBRARY_KEEP = 0;

void cf_out_of_tree_open_queue(const void *measurements, int count, size_t bytes_of_each) {
  next       = measurements;
  left       = count;
  each_bytes = bytes_of_each;
}

void cf_out_of_tree_close_queue(void) {
  left = 0;
}

const void *cf_out_of_tree_next(void) {
  if (left == 0) {
    return NULL;
  }
  const void *taken = next;
  next += each_bytes;
  left--;
  return taken;
}
