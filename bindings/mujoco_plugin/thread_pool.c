#define _POSIX_C_SOURCE 200809L  // clock_gettime
#include "mujoco_plugin/thread_pool.h"

#include <pthread.h>
#include <sched.h>
#include <stdatomic.h>
#include <stdint.h>
#include <time.h>

// The next loop follows when the physics of a step is done, tens to hundreds of microseconds later.
// Waking a sleeping thread takes as long, so a waiting one looks about a millisecond before it
// sleeps.
#define SPINS_BEFORE_SLEEP 30000

// A thread that lost its processor shows that the machine has other work. One tenth of the time may
// go to such absences, as a virtual machine takes some in any case; beyond a reserve no loop is
// shared for a while, and waiting threads sleep. Each time that comes soon after another one
// doubles the while. Thus threads that are not run cost little, whatever the load.
#define SHORTEST_ABSENCE 500000  // [ns]
#define ALLOWED_SHARE 0.1        // of absences
#define RESERVE 2000000          // [ns], of absences
#define LEAST_ALONE 100000000    // [ns]
#define CALM 1000000000          // [ns]
#define MOST_ALONE 1000000000    // [ns]
#define SPINS_PER_GLANCE 64      // at the clock

#define MAX_PARTS UINT16_MAX  // in a loop

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

// What is left of the share of a thread: parts first to last - 1 of loop number `generation`, in
// one number, so that a part is taken by one exchange. Its owner takes from the front, others from
// the back. A thread that the system did not run for a while finds another generation and takes
// nothing.
typedef struct {
  uint32_t generation;
  uint16_t first;
  uint16_t last;
} ticket_t;

typedef struct {
  _Alignas(64) _Atomic uint64_t ticket;
} share_t;

// The pool belongs to the process, not to a drone: this is the only mutable state of the C side
// outside mjData.
static struct {
  pthread_mutex_t turn;  // one loop at a time
  pthread_mutex_t lock;  // guards the sleep of the workers
  pthread_cond_t  wake;
  pthread_t       workers[CF_MAX_THREADS];
  int             threads;
  atomic_bool     is_stopping;
  loop_t          loop;  // read only by threads that hold a part of it
  atomic_int      sharing;
  share_t         shares[CF_MAX_THREADS];
  atomic_int      unfinished;  // parts of the present loop
  atomic_uint     generation;  // counts loops; workers wait for a change
  atomic_int      sleepers;
  _Atomic int64_t alone_until;  // [ns] of the clock
  int64_t         alone;        // [ns], how long it was the last time; guarded by the lock
  int64_t         absent;       // [ns], beyond what is allowed; guarded by the lock
  int64_t         absent_at;    // [ns] of the clock; guarded by the lock
} pool = {.turn    = PTHREAD_MUTEX_INITIALIZER,
          .lock    = PTHREAD_MUTEX_INITIALIZER,
          .wake    = PTHREAD_COND_INITIALIZER,
          .threads = 1};

static uint64_t packed(ticket_t ticket) {
  return (uint64_t)ticket.generation << 32 | (uint64_t)ticket.last << 16 | ticket.first;
}

static ticket_t unpacked(uint64_t number) {
  return (ticket_t){.generation = (uint32_t)(number >> 32),
                    .last       = (uint16_t)(number >> 16),
                    .first      = (uint16_t)number};
}

// Takes a part of a share, or returns -1 when none is left.
static int take_part(share_t *share, bool is_own) {
  uint64_t before = atomic_load_explicit(&share->ticket, memory_order_acquire);
  for (;;) {
    ticket_t ticket = unpacked(before);
    if (ticket.first >= ticket.last) {
      return -1;
    }
    const int part = is_own ? ticket.first++ : --ticket.last;
    if (atomic_compare_exchange_weak_explicit(&share->ticket, &before, packed(ticket),
                                              memory_order_acquire, memory_order_acquire)) {
      return part;
    }
  }
}

static void do_part(int part) {
  const loop_t loop  = pool.loop;
  const int    begin = part * loop.grain;
  const int    end   = begin + loop.grain;
  loop.body(loop.context, begin, end < loop.count ? end : loop.count);
  atomic_fetch_sub_explicit(&pool.unfinished, 1, memory_order_release);
}

// A thread works on its own share first, so that it meets the same drones in each loop, and then
// helps the others. Returns the number of parts.
static int take_parts(int self) {
  const int sharing = atomic_load_explicit(&pool.sharing, memory_order_relaxed);
  int       taken   = 0;
  for (int i = 0; i < sharing; i++) {
    const int index = (self + i) % sharing;
    share_t  *share = &pool.shares[index];
    int       part;
    while ((part = take_part(share, index == self)) >= 0) {
      do_part(part);
      taken++;
    }
  }
  return taken;
}

static int64_t now(void) {
  struct timespec time;
  clock_gettime(CLOCK_MONOTONIC, &time);
  return (int64_t)time.tv_sec * 1000000000 + time.tv_nsec;
}

static void go_alone(int64_t time) {
  const bool is_new = time - atomic_load(&pool.alone_until) > CALM;
  pool.alone        = is_new ? LEAST_ALONE : pool.alone < MOST_ALONE ? 2 * pool.alone : pool.alone;
  pool.absent       = 0;
  atomic_store(&pool.alone_until, time + pool.alone);
}

// The system took a thread off its processor for so long [ns].
static void note_absence(int64_t time, int64_t absence) {
  pthread_mutex_lock(&pool.lock);
  const int64_t paid = (int64_t)(ALLOWED_SHARE * (double)(time - pool.absent_at));
  pool.absent        = (pool.absent > paid ? pool.absent - paid : 0) + absence;
  pool.absent_at     = time;
  if (pool.absent > RESERVE && time > atomic_load(&pool.alone_until)) {
    go_alone(time);
  }
  pthread_mutex_unlock(&pool.lock);
}

static bool is_kept_away(void) {
  const int64_t until = atomic_load_explicit(&pool.alone_until, memory_order_relaxed);
  return until != 0 && now() < until;
}

// Returns true when the next loop has begun, false when that takes long or the processor is wanted
// by others.
static bool look_for_change(unsigned seen) {
  int64_t last = now();
  for (int i = 0; i < SPINS_BEFORE_SLEEP; i++) {
    if (atomic_load_explicit(&pool.generation, memory_order_acquire) != seen) {
      return true;
    }
    relax();
    if (i % SPINS_PER_GLANCE == 0) {
      const int64_t time = now();
      if (time - last > SHORTEST_ABSENCE) {
        note_absence(time, time - last);
        return false;
      }
      last = time;
    }
  }
  return false;
}

static unsigned wait_for_change(unsigned seen) {
  if (!look_for_change(seen)) {
    pthread_mutex_lock(&pool.lock);
    atomic_fetch_add(&pool.sleepers, 1);
    while (atomic_load(&pool.generation) == seen) {
      pthread_cond_wait(&pool.wake, &pool.lock);
    }
    atomic_fetch_sub(&pool.sleepers, 1);
    pthread_mutex_unlock(&pool.lock);
  }
  return atomic_load(&pool.generation);
}

static void *work(void *number) {
  const int self = (int)(intptr_t)number;
  unsigned  seen = 0;
  while (!atomic_load_explicit(&pool.is_stopping, memory_order_acquire)) {
    take_parts(self);
    seen = wait_for_change(seen);
  }
  return NULL;
}

static void announce(void) {
  atomic_fetch_add(&pool.generation, 1);
  if (atomic_load(&pool.sleepers) > 0) {
    pthread_mutex_lock(&pool.lock);
    pthread_cond_broadcast(&pool.wake);
    pthread_mutex_unlock(&pool.lock);
  }
}

// Divides the parts evenly; thread 0 is the one that started the loop.
static void hand_out(int parts) {
  const unsigned generation = atomic_load(&pool.generation) + 1;
  atomic_store(&pool.unfinished, parts);
  atomic_store(&pool.sharing, pool.threads);
  for (int i = 0; i < pool.threads; i++) {
    const ticket_t ticket = {.generation = generation,
                             .first      = (uint16_t)(parts * i / pool.threads),
                             .last       = (uint16_t)(parts * (i + 1) / pool.threads)};
    atomic_store_explicit(&pool.shares[i].ticket, packed(ticket), memory_order_release);
  }
}

static void stop_workers(void) {
  atomic_store(&pool.is_stopping, true);
  announce();
  for (int i = 1; i < pool.threads; i++) {
    pthread_join(pool.workers[i], NULL);
  }
  atomic_store(&pool.is_stopping, false);
  pool.threads = 1;
}

// A forked child has the memory of its parent but none of its workers. Coverage does
// not see it: the child that a test forks leaves without writing its counters.
static void forget_workers_after_fork(void) {
  pool.threads = 1;
  atomic_store(&pool.sharing, 0);  // of a loop under way, the parent does the rest
  atomic_store(&pool.sleepers, 0);
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
      if (pthread_create(&pool.workers[i], NULL, work, (void *)(intptr_t)i) != 0) {
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
  if (is_kept_away()) {
    pthread_mutex_unlock(&pool.turn);
    return false;
  }
  const int least = (count + MAX_PARTS - 1) / MAX_PARTS;
  grain           = grain > least ? grain : least;
  pool.loop       = (loop_t){.body = body, .context = context, .count = count, .grain = grain};
  hand_out((count + grain - 1) / grain);
  announce();
  return true;
}

// Waits for a thread that is in the middle of a part, which takes as long [ns] where the system
// runs it.
static void wait_for_last(int64_t part) {
  const int64_t begin  = now();
  const int64_t allows = 2 * part > SHORTEST_ABSENCE ? 2 * part : SHORTEST_ABSENCE;
  int64_t       waited = 0;
  for (int i = 1; atomic_load_explicit(&pool.unfinished, memory_order_acquire) > 0; i++) {
    if (waited > allows) {
      sched_yield();
    } else {
      relax();
    }
    if (i % SPINS_PER_GLANCE == 0 || waited > allows) {
      waited = now() - begin;
    }
  }
  if (waited > allows) {
    note_absence(begin + waited, waited);
  }
}

void cf_loop_finish(void) {
  const int64_t begin = now();
  const int     taken = take_parts(0);
  if (atomic_load_explicit(&pool.unfinished, memory_order_acquire) > 0) {
    wait_for_last(taken > 0 ? (now() - begin) / taken : 0);
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
