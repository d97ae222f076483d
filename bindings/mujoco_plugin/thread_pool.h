/* A few threads that share a loop: one fork and join per call, no queue, no allocation per call. */
#ifndef CF_MUJOCO_PLUGIN_THREAD_POOL_H
#define CF_MUJOCO_PLUGIN_THREAD_POOL_H

#define CF_MAX_THREADS 64

// Sets how many threads share a loop, the calling one included. Returns the number in force: at
// least 1, at most CF_MAX_THREADS. Must not be called while a loop runs.
int cf_threads_set(int count);

// Number of threads in force.
int cf_threads_get(void);

// Calls body(context, begin, end) on parts that cover [0, count), and returns when all are done.
// Concurrent callers take turns. Parts of fewer than `grain` items are not split further.
void cf_parallel_for(int count, int grain, void (*body)(void *context, int begin, int end),
                     void *context);

#endif  // CF_MUJOCO_PLUGIN_THREAD_POOL_H
