// Every item of a loop is visited exactly once, whatever the number of threads.

#include "mujoco_plugin/thread_pool.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>

#include "check.h"

#define MOST 1000

typedef void (*body_t)(void *context, int begin, int end);

// Loops are refused for a while when the machine has other work.
static void start(int count, int grain, body_t body, void *context) {
  while (!cf_loop_start(count, grain, body, context)) {
  }
}

static void count_visits(void *context, int begin, int end) {
  int *visits = context;
  CHECK(0 <= begin && begin < end);
  for (int i = begin; i < end; i++) {
    visits[i]++;
  }
}

static void check_visited_once(const int *visits, int count) {
  for (int i = 0; i < MOST; i++) {
    CHECK(visits[i] == (i < count ? 1 : 0));
  }
}

static void test_every_item_is_visited_once(void) {
  for (int threads = 1; threads <= 4; threads++) {
    CHECK(cf_threads_set(threads) == threads);
    CHECK(cf_threads_get() == threads);
    for (int round = 0; round < 200; round++) {
      const int count        = 1 + (round * 37) % MOST;
      const int grain        = 1 + round % 9;
      int       visits[MOST] = {0};
      cf_parallel_for(count, grain, count_visits, visits);
      check_visited_once(visits, count);
    }
  }
}

static void test_a_started_loop_runs_beside_its_caller_and_refuses_another(void) {
  CHECK(cf_threads_set(3) == 3);
  for (int round = 0; round < 200; round++) {
    int visits[MOST] = {0};
    int other[MOST]  = {0};
    start(MOST, 8, count_visits, visits);
    CHECK(!cf_loop_start(MOST, 8, count_visits, other));
    cf_parallel_for(MOST, 8, count_visits, other);  // does everything itself
    cf_loop_finish();
    check_visited_once(visits, MOST);
    check_visited_once(other, MOST);
  }
}

typedef struct {
  pthread_t   caller;
  atomic_bool is_held;  // a worker has taken a part
  atomic_int  done;     // items, by the caller
} hold_t;

// A worker keeps its part until the caller has done all others.
static void hold(void *context, int begin, int end) {
  hold_t *hold = context;
  if (pthread_equal(pthread_self(), hold->caller)) {
    atomic_fetch_add(&hold->done, end - begin);
    return;
  }
  atomic_store(&hold->is_held, true);
  while (atomic_load(&hold->done) < MOST - (end - begin)) {
  }
}

static void test_the_caller_does_the_share_of_a_worker_that_does_not_get_on(void) {
  CHECK(cf_threads_set(2) == 2);
  hold_t context = {.caller = pthread_self()};
  start(MOST, 8, hold, &context);
  while (!atomic_load(&context.is_held)) {
  }
  cf_loop_finish();
  CHECK(atomic_load(&context.done) == MOST - 8);
}

static void test_little_work_and_one_thread_are_not_shared(void) {
  int visits[MOST] = {0};
  CHECK(cf_threads_set(2) == 2);
  CHECK(!cf_loop_start(15, 8, count_visits, visits));
  CHECK(cf_threads_set(1) == 1);
  CHECK(!cf_loop_start(MOST, 8, count_visits, visits));
  check_visited_once(visits, 0);
}

static void test_number_of_threads_is_kept_within_bounds(void) {
  CHECK(cf_threads_set(-5) == 1);
  CHECK(cf_threads_set(1000) == CF_MAX_THREADS);
  CHECK(cf_threads_set(1) == 1);
}

int main(void) {
  test_every_item_is_visited_once();
  test_a_started_loop_runs_beside_its_caller_and_refuses_another();
  test_the_caller_does_the_share_of_a_worker_that_does_not_get_on();
  test_little_work_and_one_thread_are_not_shared();
  test_number_of_threads_is_kept_within_bounds();
  return 0;
}
