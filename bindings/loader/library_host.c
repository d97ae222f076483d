#include "loader/library_host.h"

#include <stddef.h>
#include <string.h>

#include "crazyflie.h"
#include "loader/rescue.h"

#define MAX_TABLES (CF_PROVIDER_MAX_TABLES + 32)

// The provider block is the last member of a drone.
static cf_t *drone_of(void *state) {
  return (cf_t *)(void *)((char *)state - offsetof(cf_t, provider_state));
}

static void print(void *state, const char *text) {
  cf_console_print(&drone_of(state)->onboard.console, text);
}

static void fail(void *state, const char *reason) {
  cf_onboard_fail_because(&drone_of(state)->onboard, reason);
}

// Of several rows with one name the last one counts, as for clients.
static void *find(cf_t *cf, const cf_variables_t *tables, int count, const char *group,
                  const char *name, int *type) {
  void *found = NULL;
  for (int i = 0; i < count && i < MAX_TABLES; i++) {
    for (int k = 0; k < tables[i].count; k++) {
      const cf_variable_t *row = &tables[i].rows[k];
      if (strcmp(row->name, name) == 0 && strcmp(row->group, group) == 0) {
        found = (char *)cf + tables[i].base + row->offset;
        *type = row->type;
      }
    }
  }
  return found;
}

static void *log_variable(void *state, const char *group, const char *name, int *type) {
  cf_t          *cf = drone_of(state);
  cf_variables_t tables[MAX_TABLES];
  const int      count = cf_logs(cf->config.provider, tables, MAX_TABLES);
  return find(cf, tables, count, group, name, type);
}

static void *parameter(void *state, const char *group, const char *name, int *type) {
  cf_t          *cf = drone_of(state);
  cf_variables_t tables[MAX_TABLES];
  const int      count = cf_parameters(cf->config.provider, tables, MAX_TABLES);
  return find(cf, tables, count, group, name, type);
}

static bool name_of(void *state, bool is_log, const void *address, const char **group,
                    const char **name) {
  cf_t          *cf = drone_of(state);
  cf_variables_t tables[MAX_TABLES];
  const int      provider = cf->config.provider;
  const int      count =
      is_log ? cf_logs(provider, tables, MAX_TABLES) : cf_parameters(provider, tables, MAX_TABLES);
  for (int i = 0; i < count && i < MAX_TABLES; i++) {
    for (int k = 0; k < tables[i].count; k++) {
      const cf_variable_t *row = &tables[i].rows[k];
      if ((char *)cf + tables[i].base + row->offset == (const char *)address) {
        *group = row->group;
        *name  = row->name;
        return true;
      }
    }
  }
  return false;
}

const cf_library_host_t *cf_library_host(void) {
  static const cf_library_host_t HOST = {.console      = print,
                                         .fail         = fail,
                                         .log_variable = log_variable,
                                         .parameter    = parameter,
                                         .name_of      = name_of,
                                         .set_rescue   = cf_rescue_set};
  return &HOST;
}

int cf_library_load(const cf_library_t *library, char message[CF_LIBRARY_MESSAGE_BYTES]) {
  return cf_library_add(library, cf_library_host(), message);
}
