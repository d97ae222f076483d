// A provider library for tests: the built-in algorithms, some of them wrapped in code that keeps
// what it remembers in file-scope variables. It does by hand what a real library does by its map.
//
// The built-in table comes from the process that loads it, by its address in TOY_BUILTIN. Compiled
// with TOY_ABI, TOY_ENTRY, TOY_PADDING [bytes] or TOY_GAIN it is another library.

#define _POSIX_C_SOURCE 200809L  // sigsetjmp

#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

#include "library/library.h"
#include "variable_row.h"

#ifndef TOY_ABI
#define TOY_ABI CF_LIBRARY_ABI
#endif
#ifndef TOY_ENTRY
#define TOY_ENTRY cf_library_open
#endif
#ifndef TOY_PADDING
#define TOY_PADDING 0
#endif
#ifndef TOY_GAIN
#define TOY_GAIN 1.0f
#endif

enum { WORK = 0, FAIL = 1, READ_NULL = 2, DIVIDE = 3, RECURSE = 4, GARBLE = 5 };

typedef struct {
  // parameters
  float   gain;
  uint8_t mishap;  // one of the above, at the next call of the controller
  uint8_t is_out_of_tree;
  uint8_t reserved[2];

  // log variables
  uint32_t calls;  // of the controller
  uint32_t ticks;  // begun
  uint32_t ended;
  uint32_t measurements;  // that the out-of-tree estimator got
  uint32_t refreshed;     // twice the calls, at a refresh of logs
  uint32_t written;       // parameters by clients
  int16_t  battery;       // [cV], looked up from the drone's own log
  int16_t  reserved2[3];  // whole words of 8
} image_t;

static image_t image;  // of the drone at work
static float   ballast = 2.5f;

static const cf_provider_t     *builtin;
static const cf_library_host_t *host;
static cf_provider_t            table;

static char *home(void *state) {
  return (char *)state + builtin->state_bytes;
}

static uint32_t *tail(void *state) {
  return (uint32_t *)(void *)(home(state) + sizeof image + TOY_PADDING);
}

static void swap_in(void *state) {
  memcpy(&image, home(state), sizeof image);
}

static void swap_out(void *state) {
  memcpy(home(state), &image, sizeof image);
}

// ---------------------------------------------------------------------------------------- mishaps

static volatile int zero;
static int *volatile nowhere;

static int recurse(int depth) {
  volatile char room[4096];
  room[0] = (char)depth;
  return recurse(depth + 1) + room[0];
}

static void commit(void *state, control_t *control) {
  switch (image.mishap) {
    case FAIL:
      host->fail(state, "assertion failed: thrust >= 0 (my_controller.c:12)");
      break;
    case READ_NULL:
      control->thrust = (float)*nowhere;
      break;
    case DIVIDE:
      control->thrust = (float)(7 / zero);
      break;
    case RECURSE:
      control->thrust = (float)recurse(0);
      break;
    case GARBLE:
      control->thrust = 0.0f / (float)zero;
      break;
    default:
      break;
  }
}

// -------------------------------------------------------------------------------------- functions

static cf_status_t init(void *state, cf_platform_t platform, uint32_t now_ms) {
  image = (image_t){.gain = TOY_GAIN};
  host->console(state, "TOY: hello\n");
  *tail(state) = 0;
  swap_out(state);
  if (getenv("TOY_FAILS_AT_BOOT") != NULL) {
    host->fail(state, "no parts left");
  }
  return builtin->init(state, platform, now_ms);
}

static void begin(void *state) {
  swap_in(state);
  image.ticks++;
  swap_out(state);
}

static void end(void *state) {
  swap_in(state);
  image.ended = image.ticks;
  swap_out(state);
}

static cf_status_t controller_init(void *state, int type) {
  swap_in(state);
  image.is_out_of_tree = type == ControllerTypeOot;
  swap_out(state);
  return builtin->controller_init(state, type == ControllerTypeOot ? ControllerTypePID : type);
}

static int controller_type(const void *state) {
  swap_in((void *)(uintptr_t)state);
  return image.is_out_of_tree ? ControllerTypeOot : builtin->controller_type(state);
}

static const char *controller_name(int type) {
  return type == ControllerTypeOot ? "OutOfTree" : builtin->controller_name(type);
}

static void look_up_battery(void *state) {
  int    type    = -1;
  float *voltage = host->log_variable(state, "pm", "vbat", &type);
  if (type == CF_TYPE_FLOAT) {
    image.battery = (int16_t)(*voltage * 100.0f);
  }
}

static void controller(void *state, control_t *control, const setpoint_t *setpoint,
                       const sensorData_t *sensors, const state_t *estimate,
                       stabilizerStep_t step) {
  swap_in(state);
  if (*tail(state) != image.calls || ballast != 2.5f) {
    host->fail(state, "somebody else was here");
  }
  builtin->controller(state, control, setpoint, sensors, estimate, step);
  control->thrust *= image.gain;
  sigjmp_buf rescue;
  if (sigsetjmp(rescue, 0) == 0) {
    host->set_rescue(&rescue);
    commit(state, control);
  } else {
    host->fail(state, "crashed in controllerOutOfTree");
  }
  host->set_rescue(NULL);
  image.calls++;
  if (image.calls == 1) {
    look_up_battery(state);
  }
  *tail(state) = image.calls;
  swap_out(state);
}

static void estimator_init(void *state) {
  swap_in(state);
  image.measurements = 0;
  swap_out(state);
}

static void estimator(void *state, const measurement_t *queue, int count, state_t *estimate,
                      stabilizerStep_t step, uint32_t now_ms) {
  (void)step;
  (void)now_ms;
  swap_in(state);
  image.measurements += (uint32_t)count;
  swap_out(state);
  for (int i = 0; i < count; i++) {
    if (queue[i].type == MeasurementTypePose) {
      estimate->position.x = queue[i].data.pose.x;
      estimate->position.y = queue[i].data.pose.y;
      estimate->position.z = queue[i].data.pose.z;
    }
    if (queue[i].type == MeasurementTypeSweepAngle) {
      estimate->position.z = queue[i].data.sweepAngle.rotorPos != NULL ? 7.0f : -7.0f;
    }
  }
}

// -------------------------------------------------------------------------------------- variables

static const cf_variable_t PARAMETERS[] = {
    CF_ROW("toy", "gain", FLOAT, CF_CORE, image_t, gain),
    CF_ROW("toy", "mishap", UINT8, 0, image_t, mishap),
};

static const cf_variable_t LOGS[] = {
    CF_ROW("toy", "calls", UINT32, 0, image_t, calls),
    CF_ROW("toy", "ticks", UINT32, 0, image_t, ticks),
    CF_ROW("toy", "ended", UINT32, 0, image_t, ended),
    CF_ROW("toy", "measurements", UINT32, 0, image_t, measurements),
    CF_ROW("toy", "refreshed", UINT32, 0, image_t, refreshed),
    CF_ROW("toy", "written", UINT32, 0, image_t, written),
    CF_ROW("toy", "battery", INT16, 0, image_t, battery),
    CF_ROW("toy", "gain", FLOAT, 0, image_t, gain),
};

static int add(cf_variables_t *tables, int capacity, int count, cf_variables_t own) {
  if (count < capacity) {
    own.base      = (uint32_t)builtin->state_bytes;
    tables[count] = own;
  }
  return count + 1;
}

static int parameters(cf_variables_t *tables, int capacity) {
  return add(tables, capacity, builtin->parameters(tables, capacity), CF_TABLE(PARAMETERS));
}

static int logs(cf_variables_t *tables, int capacity) {
  return add(tables, capacity, builtin->logs(tables, capacity), CF_TABLE(LOGS));
}

static void parameter_written(void *state, const char *group, const char *name) {
  int type = -1;
  swap_in(state);
  if (strcmp(group, "toy") == 0 && host->parameter(state, group, name, &type) != NULL) {
    image.written++;
  }
  swap_out(state);
}

static void refresh_logs(void *state) {
  swap_in(state);
  image.refreshed = 2 * image.calls;
  swap_out(state);
}

// ------------------------------------------------------------------------------------------ entry

__attribute__((visibility("default"))) const cf_provider_t *TOY_ENTRY(int                      abi,
                                                                      const cf_library_host_t *core,
                                                                      const cf_image_map_t *map) {
  if (abi != TOY_ABI || map == NULL) {
    return NULL;
  }
  builtin               = (const cf_provider_t *)strtoull(getenv("TOY_BUILTIN"), NULL, 16);
  host                  = core;
  table                 = *builtin;
  table.name            = "toy";
  table.state_bytes     = builtin->state_bytes + sizeof image + TOY_PADDING + 8;
  table.begin           = begin;
  table.end             = end;
  table.init            = init;
  table.controller_init = controller_init;
  table.controller_type = controller_type;
  table.controller_name = controller_name;
  table.controller      = controller;
  table.out_of_tree_estimator_init = estimator_init;
  table.out_of_tree_estimator      = estimator;
  table.parameters                 = parameters;
  table.logs                       = logs;
  table.parameter_written          = parameter_written;
  table.refresh_logs               = refresh_logs;
  return &table;
}
