#include "library/captured.h"

#include <stdlib.h>
#include <string.h>

#include "library/captured_variables.h"
#include "library/image.h"
#include "library/inner.h"

_Static_assert(sizeof(cf_captured_t) == 32, "tables of different files follow without gaps");

// The sections begin and end where the linker says. These rows make sure that there are sections.
extern const cf_captured_t __start_cf_parameters[] __attribute__((visibility("hidden")));
extern const cf_captured_t __stop_cf_parameters[] __attribute__((visibility("hidden")));
extern const cf_captured_t __start_cf_logs[] __attribute__((visibility("hidden")));
extern const cf_captured_t __stop_cf_logs[] __attribute__((visibility("hidden")));

// a name, so that these are as writable as those with addresses: a section is one or the other
static const cf_captured_t no_parameter[] CF_CAPTURED_PARAMETERS = {{.name = ""}};
static const cf_captured_t no_log[] CF_CAPTURED_LOGS             = {{.name = ""}};

// Where the values of computed log variables are kept, a part of the image. A checkout has some ten
// of them, rates most of the time; what is beyond is dropped.
#define MAX_COMPUTED 64
static union {
  uint32_t word;
  float    number;
} cells[MAX_COMPUTED];

// A computed variable as the firmware declares it: one of seven functions, and what it is handed.
typedef struct {
  union {
    uint8_t (*uint8)(uint32_t timestamp, void *data);
    uint16_t (*uint16)(uint32_t timestamp, void *data);
    uint32_t (*uint32)(uint32_t timestamp, void *data);
    int8_t (*int8)(uint32_t timestamp, void *data);
    int16_t (*int16)(uint32_t timestamp, void *data);
    int32_t (*int32)(uint32_t timestamp, void *data);
    float (*number)(uint32_t timestamp, void *data);
  };
  void *data;
} function_t;

typedef struct {
  const function_t *function;
  cf_type_t         type;
} computed_t;

typedef struct {
  cf_variable_t        *rows;
  const cf_captured_t **captured;  // which each row came from
  int                   count;
} table_t;

static table_t parameters CF_LIBRARY_KEEP                        = {.rows = NULL};
static table_t logs       CF_LIBRARY_KEEP                        = {.rows = NULL};
static computed_t         computed[MAX_COMPUTED] CF_LIBRARY_KEEP = {{.function = NULL}};
static int n_computed     CF_LIBRARY_KEEP                        = 0;
static int n_dropped      CF_LIBRARY_KEEP                        = 0;

// ---------------------------------------------------------------------------------------- reading

size_t cf_captured_size(int type) {
  switch (type) {
    case CF_TYPE_UINT8:
    case CF_TYPE_INT8:
      return 1;
    case CF_TYPE_UINT16:
    case CF_TYPE_INT16:
      return 2;
    case CF_TYPE_UINT32:
    case CF_TYPE_INT32:
    case CF_TYPE_FLOAT:
      return 4;
  }
  return 0;  // no type that a client knows
}

static bool is_named(const cf_variable_t *row, const char *group, const char *name) {
  return strcmp(row->name, name) == 0 && strcmp(row->group, group) == 0;
}

static bool has(const cf_variable_t *rows, int count, const char *group, const char *name) {
  for (int i = 0; i < count; i++) {
    if (is_named(&rows[i], group, name)) {
      return true;
    }
  }
  return false;
}

static bool has_any(const cf_variables_t *tables, int n_tables, const char *group,
                    const char *name) {
  for (int i = 0; i < n_tables; i++) {
    if (has(tables[i].rows, tables[i].count, group, name)) {
      return true;
    }
  }
  return false;
}

// The offset in a block of what this row describes, or -1.
static ptrdiff_t place(const cf_captured_t *row) {
  const size_t bytes = cf_captured_size(row->type);
  if (bytes == 0) {
    return -1;
  }
  if (row->kind == CF_CAPTURED_VARIABLE) {
    return cf_image_offset(row->address, bytes);
  }
  if (n_computed == MAX_COMPUTED) {
    return -1;
  }
  const ptrdiff_t at     = cf_image_offset(&cells[n_computed], sizeof cells[0]);
  computed[n_computed++] = (computed_t){.function = row->address, .type = (cf_type_t)row->type};
  return at;
}

static void take(table_t *table, const cf_captured_t *row, const char *group) {
  const ptrdiff_t at = place(row);
  if (at < 0) {
    n_dropped++;
    return;
  }
  table->captured[table->count] = row;
  table->rows[table->count++]   = (cf_variable_t){
      .group  = group,
      .name   = row->name,
      .type   = (cf_type_t)row->type,
      .flags  = row->flags,
      .offset = (uint32_t)at,
  };
}

static bool read(table_t *table, const cf_captured_t *from, const cf_captured_t *end,
                 int (*list)(cf_variables_t *, int)) {
  cf_variables_t known[CF_PROVIDER_MAX_TABLES];
  const int      listed  = list != NULL ? list(known, CF_PROVIDER_MAX_TABLES) : 0;
  const int      n_known = listed < CF_PROVIDER_MAX_TABLES ? listed : CF_PROVIDER_MAX_TABLES;

  const size_t most = (size_t)(end - from);  // never none: see no_log
  table->rows       = calloc(most, sizeof *table->rows);
  table->captured   = calloc(most, sizeof *table->captured);
  if (table->rows == NULL || table->captured == NULL) {
    return false;
  }
  const char *group = "";
  for (const cf_captured_t *row = from; row < end; row++) {
    if (row->kind == CF_CAPTURED_GROUP) {
      group = row->name;
    } else if (row->kind != CF_CAPTURED_NOTHING && !has_any(known, n_known, group, row->name) &&
               !has(table->rows, table->count, group, row->name)) {
      take(table, row, group);
    }
  }
  return true;
}

bool cf_captured_open(const cf_provider_t *inner) {
  return read(&parameters, __start_cf_parameters, __stop_cf_parameters, inner->parameters) &&
         read(&logs, __start_cf_logs, __stop_cf_logs, inner->logs);
}

// ----------------------------------------------------------------------------------------- tables

cf_variables_t cf_captured_parameters(void) {
  return (cf_variables_t){.rows = parameters.rows, .count = parameters.count, .base = 0};
}

cf_variables_t cf_captured_logs(void) {
  return (cf_variables_t){.rows = logs.rows, .count = logs.count, .base = 0};
}

int cf_captured_dropped(void) {
  return n_dropped;
}

// ----------------------------------------------------------------------------- what is run by name

static void call_back(const cf_captured_t *parameter) {
  if (parameter->callback != NULL) {
    parameter->callback();
  }
}

void cf_captured_parameter_written(const char *group, const char *name) {
  for (int i = 0; i < parameters.count; i++) {
    if (is_named(&parameters.rows[i], group, name)) {
      call_back(parameters.captured[i]);
      return;
    }
  }
}

void cf_captured_parameter_set(const void *address) {
  for (int i = 0; i < parameters.count; i++) {
    if (parameters.captured[i]->address == address) {
      call_back(parameters.captured[i]);
      return;
    }
  }
}

static void compute(int i) {
  const function_t *log = computed[i].function;
  const uint32_t    now = cf_library_now_ms();
  if (log->uint32 == NULL) {  // of whatever type
    return;
  }
  switch (computed[i].type) {
    case CF_TYPE_UINT8:
      cells[i].word = log->uint8(now, log->data);
      break;
    case CF_TYPE_UINT16:
      cells[i].word = log->uint16(now, log->data);
      break;
    case CF_TYPE_UINT32:
      cells[i].word = log->uint32(now, log->data);
      break;
    case CF_TYPE_INT8:
      cells[i].word = (uint32_t)log->int8(now, log->data);
      break;
    case CF_TYPE_INT16:
      cells[i].word = (uint32_t)log->int16(now, log->data);
      break;
    case CF_TYPE_INT32:
      cells[i].word = (uint32_t)log->int32(now, log->data);
      break;
    case CF_TYPE_FLOAT:
      cells[i].number = log->number(now, log->data);
      break;
  }
}

void cf_captured_refresh_logs(void) {
  for (int i = 0; i < n_computed; i++) {
    compute(i);
  }
}

void cf_captured_refresh_log(const void *address) {
  for (int i = 0; i < n_computed; i++) {
    if (address == &cells[i]) {
      compute(i);
    }
  }
}
