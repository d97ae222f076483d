/* Replaces the core of a provider library, for tests: records the output of libraries, and returns
 * from functions that crashed. */
#include "host.h"

#include <setjmp.h>
#include <signal.h>
#include <stdio.h>
#include <string.h>

host_record_t        host_record;
const cf_provider_t *host_provider;

static sigjmp_buf *rescue;

static void console(void *state, const char *text) {
  host_record.drone = state;
  const size_t used = strlen(host_record.console);
  snprintf(host_record.console + used, sizeof host_record.console - used, "%s", text);
}

static void fail(void *state, const char *reason) {
  host_record.failures++;
  host_record.drone = state;
  snprintf(host_record.reason, sizeof host_record.reason, "%s", reason);
}

static void set_rescue(void *buffer) {
  rescue = buffer;
}

static void *find(const cf_variables_t *tables, int count, char *block, const char *group,
                  const char *name, int *type) {
  for (int i = 0; i < count; i++) {
    for (int k = 0; k < tables[i].count; k++) {
      const cf_variable_t *row = &tables[i].rows[k];
      if (strcmp(row->group, group) == 0 && strcmp(row->name, name) == 0) {
        *type = (int)row->type;
        return block + tables[i].base + row->offset;
      }
    }
  }
  return NULL;
}

static host_drone_t *drone_of(void *block) {
  return (host_drone_t *)((char *)block - sizeof(host_drone_t));
}

static void *log_variable(void *state, const char *group, const char *name, int *type) {
  if (strcmp(group, "host") == 0 && strcmp(name, "height") == 0) {
    *type = CF_TYPE_FLOAT;
    return &drone_of(state)->height;
  }
  cf_variables_t tables[CF_PROVIDER_MAX_TABLES];
  const int      count = host_provider->logs(tables, CF_PROVIDER_MAX_TABLES);
  return find(tables, count, state, group, name, type);
}

static void *parameter(void *state, const char *group, const char *name, int *type) {
  if (strcmp(group, "host") == 0 && strcmp(name, "selector") == 0) {
    *type = CF_TYPE_UINT8;
    return &drone_of(state)->selector;
  }
  cf_variables_t tables[CF_PROVIDER_MAX_TABLES];
  const int      count = host_provider->parameters(tables, CF_PROVIDER_MAX_TABLES);
  return find(tables, count, state, group, name, type);
}

static bool name_of(void *state, bool is_log, const void *address, const char **group,
                    const char **name) {
  cf_variables_t tables[CF_PROVIDER_MAX_TABLES];
  const int      count = is_log ? host_provider->logs(tables, CF_PROVIDER_MAX_TABLES)
                                : host_provider->parameters(tables, CF_PROVIDER_MAX_TABLES);
  for (int i = 0; i < count; i++) {
    for (int k = 0; k < tables[i].count; k++) {
      const cf_variable_t *row = &tables[i].rows[k];
      if ((char *)state + tables[i].base + row->offset == (const char *)address) {
        *group = row->group;
        *name  = row->name;
        return true;
      }
    }
  }
  return false;
}

cf_library_host_t host = {
    .console      = console,
    .fail         = fail,
    .log_variable = log_variable,
    .parameter    = parameter,
    .name_of      = name_of,
    .set_rescue   = set_rescue,
};

// ---------------------------------------------------------------------------------------- signals

static const int        SIGNALS[] = {SIGSEGV, SIGBUS, SIGFPE, SIGABRT};
static struct sigaction earlier[sizeof SIGNALS / sizeof SIGNALS[0]];

static void on_signal(int signal) {
  if (rescue != NULL) {
    siglongjmp(*rescue, signal);
  }
  // a crash of the test itself: raise the signal again with the default handler
  struct sigaction by_default = {.sa_handler = SIG_DFL};
  sigaction(signal, &by_default, NULL);
  raise(signal);
}

void host_catch_crashes(void) {
  struct sigaction action = {.sa_handler = on_signal};
  for (size_t i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
    sigaction(SIGNALS[i], &action, &earlier[i]);
  }
}

void host_catch_no_crashes(void) {
  for (size_t i = 0; i < sizeof SIGNALS / sizeof SIGNALS[0]; i++) {
    sigaction(SIGNALS[i], &earlier[i], NULL);
  }
}

bool host_has_rescue(void) {
  return rescue != NULL;
}
