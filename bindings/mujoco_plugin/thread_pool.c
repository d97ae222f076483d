#include "mujoco_plugin/thread_pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdint.h>

// The next loop follows when the physics of a step is done, tens to hundreds of microseconds later.
// Waking a sleeping thread takes as long, so a waiting one looks about a millisecond before it
// sleeps.
#define SPINS_BEFORE_SLEEP 30000
#define SPINS_BEFORE_YIELD 4000

static void relax(void) {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  __asm__ volatile("yield");
#endif
}

typedef struct {
  void (*body)(void *context, int begin, int end);
  void *context;
  int   count;
  int   grain;
} loop_t;

// The pool belongs to the process, not to a drone: this is the only mutable state of the C side
// outside mjData.
static struct {
  pthread_mutex_t turn;  // one loop at a time
  pthread_mutex_t lock;  // guards the sleep of the workers
  pthread_cond_t  wake;
  pthread_t       workers[CF_MAX_THREADS];
  int             threads;
  bool            is_stopping;
  loop_t          loop;
  atomic_int      next;        // first item of the loop that nobody has taken yet
  atomic_uint     generation;  // counts loops; workers wait for a change
  atomic_int      unfinished;  // workers still busy with the present loop
} pool = {.turn    = PTHREAD_MUTEX_INITIALIZER,
          .lock    = PTHREAD_MUTEX_INITIALIZER,
          .wake    = PTHREAD_COND_INITIALIZER,
          .threads = 1};

static void take_parts(void) {
  const loop_t loop = pool.loop;
  for (;;) {
    const int begin = atomic_fetch_add_explicit(&pool.next, loop.grain, memory_order_relaxed);
    if (begin >= loop.count) {
      return;
    }
    const int end = begin + loop.grain;
    loop.body(loop.context, begin, end < loop.count ? end : loop.count);
  }
}

static unsigned wait_for_change(unsigned seen) {
  for (int i = 0; i < SPINS_BEFORE_SLEEP; i++) {
    const unsigned now = atomic_load_explicit(&pool.generation, memory_order_acquire);
    if (now != seen) {
      return now;
    }
    relax();
  }
  pthread_mutex_lock(&pool.lock);
  while (atomic_load(&pool.generation) == seen) {
    pthread_cond_wait(&pool.wake, &pool.lock);
  }
  pthread_mutex_unlock(&pool.lock);
  return atomic_load(&pool.generation);
}

static void *work(void *generation_at_start) {
  unsigned seen = (unsigned)(uintptr_t)generation_at_start;
  for (;;) {
    seen = wait_for_change(seen);
    if (pool.is_stopping) {
      return NULL;
    }
    take_parts();
    atomic_fetch_sub_explicit(&pool.unfinished, 1, memory_order_release);
  }
}

static void announce(void) {
  pthread_mutex_lock(&pool.lock);
  atomic_fetch_add_explicit(&pool.generation, 1, memory_order_release);
  pthread_cond_broadcast(&pool.wake);
  pthread_mutex_unlock(&pool.lock);
}

static void stop_workers(void) {
  pool.is_stopping = true;
  announce();
  for (int i = 1; i < pool.threads; i++) {
    pthread_join(pool.workers[i], NULL);
  }
  pool.is_stopping = false;
  pool.threads     = 1;
}

// A forked child has the memory of its parent but none of its workers. Coverage does
// not see it: the child that a test forks leaves without writing its counters.
static void forget_workers_after_fork(void) {
  pool.threads = 1;
  pthread_mutex_init(&pool.turn, NULL);
  pthread_mutex_init(&pool.lock, NULL);
  pthread_cond_init(&pool.wake, NULL);
}

int cf_threads_set(int count) {
  if (count < 1) {
    count = 1;
  }
  if (count > CF_MAX_THREADS) {
    count = CF_MAX_THREADS;
  }

  pthread_mutex_lock(&pool.turn);
  if (count != pool.threads) {
    static bool is_fork_handled = false;
    if (!is_fork_handled) {
      is_fork_handled = pthread_atfork(NULL, NULL, forget_workers_after_fork) == 0;
    }
    stop_workers();
    for (int i = 1; i < count; i++) {
      void *generation = (void *)(uintptr_t)atomic_load(&pool.generation);
      if (pthread_create(&pool.workers[i], NULL, work, generation) != 0) {
        break;  // fewer threads than asked for: the loop still covers everything
      }
      pool.threads = i + 1;
    }
  }
  const int result = pool.threads;
  pthread_mutex_unlock(&pool.turn);
  return result;
}

int cf_threads_get(void) {
  return pool.threads;
}

bool cf_loop_start(int count, int grain, void (*body)(void *context, int begin, int end),
                   void *context) {
  if (pool.threads == 1 || count < 2 * grain || pthread_mutex_trylock(&pool.turn) != 0) {
    return false;
  }
  pool.loop = (loop_t){.body = body, .context = context, .count = count, .grain = grain};
  atomic_store(&pool.next, 0);
  atomic_store(&pool.unfinished, pool.threads - 1);
  announce();
  return true;
}

void cf_loop_finish(void) {
  take_parts();
  for (int spins = 0; atomic_load_explicit(&pool.unfinished, memory_order_acquire) > 0; spins++) {
    relax();
    if (spins > SPINS_BEFORE_YIELD) {
      sched_yield();  // fewer cores than threads
    }
  }
  pthread_mutex_unlock(&pool.turn);
}

void cf_parallel_for(int count, int grain, void (*body)(void *context, int begin, int end),
                     void *context) {
  if (cf_loop_start(count, grain, body, context)) {
    cf_loop_finish();
  } else {
    body(context, 0, count);
  }
}
