// Provider libraries: copies for threads, drones that fly them, and what happens when they crash.

#define _GNU_SOURCE  // setenv

#include "loader/library_loader.h"

#include <dlfcn.h>
#include <math.h>
#include <pthread.h>
#include <setjmp.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

#include "check.h"
#include "crazyflie.h"
#include "loader/image_map.h"
#include "loader/library_copy.h"
#include "loader/library_host.h"
#include "loader/rescue.h"
#include "providers.h"

#define THREADS 4
#define FLIGHT 2500  // [ms]

static const cf_motion_t AT_REST = {.position       = {0.0f, 0.0f, 0.0145f},
                                    .quat_wxyz      = {1.0f, 0.0f, 0.0f, 0.0f},
                                    .rotation       = {1, 0, 0, 0, 1, 0, 0, 0, 1},
                                    .specific_force = {0.0f, 0.0f, 9.81f}};

static int load(const char *path, const char *name, const char *expected) {
  char               message[CF_LIBRARY_MESSAGE_BYTES] = "";
  const cf_library_t library = {.path = path, .name = name, .platform = -1};
  const int          number  = cf_library_load(&library, message);
  CHECK((number > 0) == (expected == NULL));
  CHECK(expected == NULL || strstr(message, expected) != NULL);
  return number;
}

static cf_t *boot(int provider) {
  cf_config_t config;
  CHECK(cf_config_default(&config, CF_PLATFORM_CF2) == CF_OK);
  config.provider = provider;
  cf_t *cf        = malloc((size_t)cf_state_bytes(provider));
  CHECK(cf != NULL && cf_init(cf, &config) == CF_OK);
  return cf;
}

static void rest(cf_t *cf, int ticks) {
  for (int i = 0; i < ticks; i++) {
    cf_tick(cf, &AT_REST);
  }
}

static void *parameter(cf_t *cf, const char *group, const char *name) {
  int   type;
  void *found = cf_library_host()->parameter(cf->provider_state, group, name, &type);
  CHECK(found != NULL);
  return found;
}

static uint32_t log_of(cf_t *cf, const char *group, const char *name) {
  int       type;
  uint32_t *found = cf_library_host()->log_variable(cf->provider_state, group, name, &type);
  CHECK(found != NULL && type == CF_TYPE_UINT32);
  return *found;
}

static void test_what_is_no_library_is_refused(void) {
  load("/nowhere/library.so", "toy", "No such file");
  load(TOY_LIBRARY, "builtin", "not 'builtin'");
  load("/", "toy", "cannot be read");
  load(__FILE__, "toy", "cannot be");
  CHECK(cf_provider_count() == 1);
  CHECK(cf_provider_find("toy", CF_PLATFORM_CF2) == CF_ERR_UNKNOWN);
  CHECK(cf_provider(1) == NULL && cf_provider_name(1) == NULL && cf_state_bytes(1) == 0);
}

static void test_a_library_flies_as_what_it_is_made_of(void) {
  const int toy = load(TOY_LIBRARY, "toy", NULL);
  CHECK(load(TOY_LIBRARY, "toy", NULL) == toy);
  CHECK(cf_provider_find("toy", CF_PLATFORM_CF21BL) == toy);
  cf_t *own    = boot(0);
  cf_t *loaded = boot(toy);
  rest(own, 2000);
  rest(loaded, 2000);
  CHECK(memcmp(&own->onboard.control, &loaded->onboard.control, sizeof own->onboard.control) == 0);
  CHECK(memcmp(&own->onboard.estimate, &loaded->onboard.estimate, sizeof(state_t)) == 0);
  CHECK(log_of(loaded, "toy", "ticks") == 2000);
  CHECK(log_of(loaded, "toy", "ended") == 2000);
  free(own);
  free(loaded);
}

static void test_clients_reach_what_the_library_computes(void) {
  cf_t *cf = boot(load(TOY_LIBRARY, "toy", NULL));
  rest(cf, 2000);
  cf_parameter_written(cf, "toy", "gain");
  cf_parameter_written(cf, "kalman", "initialX");
  cf_refresh_logs(cf, 1, 0);
  CHECK(log_of(cf, "toy", "written") == 1);
  CHECK(log_of(cf, "toy", "refreshed") == 2 * log_of(cf, "toy", "calls"));
  int type;
  CHECK(cf_library_host()->log_variable(cf->provider_state, "toy", "nothing", &type) == NULL);
  CHECK(cf_library_host()->parameter(cf->provider_state, "no", "gain", &type) == NULL);
  free(cf);

  cf_t *own = boot(0);
  cf_parameter_written(own, "kalman", "initialX");
  cf_refresh_logs(own, 1, 0);
  free(own);
}

// ---------------------------------------------------------------------------------------- threads

typedef struct {
  cf_t                *cf;
  const cf_provider_t *table;
  uint32_t             calls;
} flight_t;

static void *fly(void *context) {
  flight_t *flight = context;
  flight->table    = cf_provider(flight->cf->config.provider);
  rest(flight->cf, FLIGHT);
  flight->calls = log_of(flight->cf, "toy", "calls");
  return NULL;
}

static void test_threads_have_copies_of_their_own(void) {
  const int toy = load(TOY_LIBRARY, "toy", NULL);
  flight_t  flights[THREADS];
  for (int round = 0; round < 2; round++) {
    pthread_t threads[THREADS];
    for (int i = 0; i < THREADS; i++) {
      flights[i].cf = boot(toy);
      CHECK(pthread_create(&threads[i], NULL, fly, &flights[i]) == 0);
    }
    for (int i = 0; i < THREADS; i++) {
      CHECK(pthread_join(threads[i], NULL) == 0);
      CHECK(flights[i].cf->onboard.fault == CF_FAULT_NONE);
      CHECK(flights[i].calls > 500 && flights[i].calls == flights[0].calls);
      CHECK(flights[i].table != cf_provider(toy));
      free(flights[i].cf);
    }
  }
}

static void test_a_drone_is_as_long_as_its_library_needs(void) {
  const int toy = load(TOY_LIBRARY, "toy", NULL);
  CHECK(cf_state_bytes(0) == (int)sizeof(cf_t));
  CHECK(cf_state_bytes(toy) == (int)sizeof(cf_t));
  CHECK(cf_provider_block_bytes(toy) == (int)cf_provider(toy)->state_bytes);
}

static void test_copies_need_no_files_in_memory(void) {
  FILE *stream = fopen(TOY_LIBRARY, "rb");
  CHECK(stream != NULL);
  static uint8_t          bytes[1 << 20];
  const cf_library_file_t file = {.bytes = bytes, .size = fread(bytes, 1, sizeof bytes, stream)};
  fclose(stream);
  char  reason[CF_LIBRARY_COPY_REASON_BYTES];
  void *first  = cf_library_copy_on_disk(&file, reason);
  void *second = cf_library_copy_on_disk(&file, reason);
  CHECK(first != NULL && second != NULL && first != second);
  CHECK(dlsym(first, CF_LIBRARY_ENTRY) != dlsym(second, CF_LIBRARY_ENTRY));
  CHECK(dlclose(first) == 0 && dlclose(second) == 0);

  setenv("TMPDIR", "/nowhere", 1);
  CHECK(cf_library_copy_on_disk(&file, reason) == NULL);
  CHECK(strstr(reason, "No such file") != NULL);
  unsetenv("TMPDIR");
}

static void test_copies_in_memory_differ_whatever_their_serial(void) {
  FILE *stream = fopen(TOY_LIBRARY, "rb");
  CHECK(stream != NULL);
  static uint8_t          bytes[1 << 20];
  const cf_library_file_t file = {.bytes = bytes, .size = fread(bytes, 1, sizeof bytes, stream)};
  fclose(stream);
  // apart from those of the loader, which count from 1
  const uint32_t serials[] = {0x80000000u, 0x80000001u, 0xAAAAAAAAu, 0xFFFFFFFFu};
  void          *handles[4];
  char           reason[CF_LIBRARY_COPY_REASON_BYTES];
  for (int i = 0; i < 4; i++) {
    handles[i] = cf_library_copy_in_memory(&file, serials[i], reason);
    CHECK(handles[i] != NULL);
    for (int k = 0; k < i; k++) {
      CHECK(handles[i] != handles[k]);
    }
  }
  for (int i = 0; i < 4; i++) {
    CHECK(dlclose(handles[i]) == 0);
  }
}

// --------------------------------------------------------------------------------------- failures

static void test_a_failing_library_stops_its_drone_alone(void) {
  const char *reasons[] = {NULL, "assertion failed: thrust >= 0 (my_controller.c:12)",
                           "crashed in controllerOutOfTree"};
  for (uint8_t mishap = 1; mishap <= 2; mishap++) {
    cf_t *failing  = boot(load(TOY_LIBRARY, "toy", NULL));
    cf_t *neighbor = boot(load(TOY_LIBRARY, "toy", NULL));
    rest(failing, 2000);
    rest(neighbor, 2000);
    *(uint8_t *)parameter(failing, "toy", "mishap") = mishap;
    rest(failing, 1);
    rest(neighbor, 1);
    CHECK(failing->onboard.fault == CF_FAULT_SOFTWARE);
    CHECK(strcmp(failing->onboard.failure, reasons[mishap]) == 0);
    CHECK(neighbor->onboard.fault == CF_FAULT_NONE);
    const uint32_t calls = log_of(failing, "toy", "calls");
    rest(failing, 10);
    CHECK(log_of(failing, "toy", "calls") == calls);
    CHECK(failing->onboard.tick == 2011);
    cf_reboot(failing);
    CHECK(failing->onboard.fault == CF_FAULT_NONE);
    free(failing);
    free(neighbor);
  }
}

static void test_a_long_reason_is_cut(void) {
  cf_t *cf = boot(0);
  char  reason[300];
  memset(reason, 'x', sizeof reason);
  reason[sizeof reason - 1] = '\0';
  cf_library_host()->fail(cf->provider_state, reason);
  cf_library_host()->fail(cf->provider_state, "second");
  CHECK(strlen(cf->onboard.failure) == CF_FAILURE_BYTES - 1);
  CHECK(cf->onboard.failure[0] == 'x');
  CHECK(strcmp(cf_fault_text(cf->onboard.fault), "the onboard software failed") == 0);
  free(cf);
}

// not null, which the sanitizer would see coming
static volatile int *volatile nowhere = (volatile int *)16;

static void test_a_crash_comes_back_with_its_signal(void) {
  static sigjmp_buf rescue;
  cf_rescue_install();
  for (volatile int round = 0; round < 3; round++) {
    const int signal = sigsetjmp(rescue, 0);
    if (signal == 0) {
      cf_rescue_set(&rescue);
      if (round == 2) {
        abort();
      }
      *nowhere = 1;
      CHECK(false);
    }
    CHECK(signal == (round == 2 ? SIGABRT : SIGSEGV));
  }
  cf_rescue_set(NULL);
}

// ------------------------------------------------------------------------------------- image maps

static void test_maps_are_compared_and_copied(void) {
  const cf_image_range_t ranges[]   = {{64, 16}, {80, 8}};
  const uint32_t         pointers[] = {64, 72, 80};
  const cf_image_map_t   map        = {ranges, 2, pointers, 3};
  const cf_image_map_t   shorter    = {ranges, 2, pointers, 2};
  const cf_image_map_t   none       = {NULL, 0, NULL, 0};
  cf_image_map_t         copy;
  CHECK(cf_image_map_fault(&map) == NULL && cf_image_map_fault(&none) == NULL);
  CHECK(cf_image_map_copy(&copy, &map));
  CHECK(copy.ranges != ranges && cf_image_map_equals(&copy, &map));
  CHECK(!cf_image_map_equals(&copy, &shorter) && !cf_image_map_equals(&copy, &none));
  cf_image_map_free(&copy);
  CHECK(cf_image_map_copy(&copy, &none) && cf_image_map_equals(&copy, &none));
  cf_image_map_free(&copy);

  const uint32_t       across[] = {76};  // begins in one range and ends in another
  const cf_image_map_t torn     = {ranges, 2, across, 1};
  CHECK(cf_image_map_fault(&torn) != NULL);
}

int main(void) {
  char address[32];
  snprintf(address, sizeof address, "%p", (const void *)cf_provider(0));
  setenv("TOY_BUILTIN", address, 1);
  test_what_is_no_library_is_refused();
  test_a_library_flies_as_what_it_is_made_of();
  test_clients_reach_what_the_library_computes();
  test_threads_have_copies_of_their_own();
  test_a_drone_is_as_long_as_its_library_needs();
  test_copies_need_no_files_in_memory();
  test_copies_in_memory_differ_whatever_their_serial();
  test_a_failing_library_stops_its_drone_alone();
  test_a_long_reason_is_cut();
  test_a_crash_comes_back_with_its_signal();
  test_maps_are_compared_and_copied();
  return 0;
}
