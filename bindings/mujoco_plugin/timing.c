#define _POSIX_C_SOURCE 200809L  // clock_gettime
#include "mujoco_plugin/timing.h"

#include <stdatomic.h>
#include <stdbool.h>
#include <time.h>

#include "mujoco_plugin/plugin.h"

static atomic_bool            is_timed;
static _Atomic(uint_fast64_t) spent[TIME_PARTS];  // [ns], summed over threads

uint64_t cf_timer_start(void) {
  struct timespec now;
  if (!atomic_load_explicit(&is_timed, memory_order_relaxed)) {
    return 0;
  }
  clock_gettime(CLOCK_MONOTONIC, &now);
  return (uint64_t)now.tv_sec * 1000000000u + (uint64_t)now.tv_nsec;
}

uint64_t cf_timer_add(int part, uint64_t start) {
  const uint64_t now = cf_timer_start();
  if (now != 0 && start != 0) {
    atomic_fetch_add_explicit(&spent[part], now - start, memory_order_relaxed);
  }
  return now;
}

void cf_plugin_timing(int enabled) {
  atomic_store(&is_timed, enabled != 0);
  for (int i = 0; i < TIME_PARTS; i++) {
    atomic_store(&spent[i], 0);
  }
}

void cf_plugin_timing_read(uint64_t nanoseconds[2]) {
  for (int i = 0; i < TIME_PARTS; i++) {
    nanoseconds[i] = atomic_load(&spent[i]);
  }
}
