/* A few threads that share a loop: one fork and join per call, no queue, no allocation per call. A
 * loop is done when its parts are, whether or not the system ran every thread. */
#ifndef CF_MUJOCO_PLUGIN_THREAD_POOL_H
#define CF_MUJOCO_PLUGIN_THREAD_POOL_H

#include <stdbool.h>

#define CF_MAX_THREADS 64

// Sets how many threads share a loop, the calling one included. Returns the number in force: at
// least 1, at most CF_MAX_THREADS. Must not be called while a loop runs.
int cf_threads_set(int count);

// Number of threads in force.
int cf_threads_get(void);

// Shares body(context, begin, end) among the threads, in parts of `grain` items that cover [0,
// count), and returns at once. Returns false, and does nothing, when there is only one thread,
// little work, another loop under way, or a machine that has other work. Every start that returned
// true is followed by a finish of the same thread.
bool cf_loop_start(int count, int grain, void (*body)(void *context, int begin, int end),
                   void *context);

// Runs remaining parts of the loop in this thread and returns when the whole loop is done.
void cf_loop_finish(void);

// Both at once; without help the caller does everything itself.
void cf_parallel_for(int count, int grain, void (*body)(void *context, int begin, int end),
                     void *context);

#endif  // CF_MUJOCO_PLUGIN_THREAD_POOL_H
