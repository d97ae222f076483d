/* The firmware's functions that read log variables, and read and write parameters, by id.
 *
 * Compiled with the headers that declare them, a checkout's or those of app/include: ids are passed
 * by value, so that both sides must agree what an id is. */
#include <stddef.h>
#include <string.h>

#include "log.h"
#include "param.h"

#include "../convert.h"
#include "library/captured_variables.h"
#include "library/inner.h"
#include "library/work.h"

#define HALF_FLOAT 8  // a type to fetch as, which not all releases name

// The variables that the drone's code has looked up by name. Ids are indices of this table. The
// table is part of the image, since the ids are too: code looks up once and keeps the id.
#define MAX_KNOWN 64
#define NO_ID 0xffffu

typedef struct {
  int32_t distance;  // [bytes] from the block
  uint8_t type;      // cf_type_t
  bool    is_log;
  bool    is_in_use;
} known_t;

static known_t known[MAX_KNOWN];

// A checkout that is compiled together with its own log.c or param.c has these functions already.
#define WEAK __attribute__((weak))

static bool is_same(const known_t *a, const known_t *b) {
  return a->distance == b->distance && a->type == b->type && a->is_log == b->is_log;
}

static uint16_t know(const known_t *wanted) {
  for (uint16_t id = 0; id < MAX_KNOWN; id++) {
    if (!known[id].is_in_use) {
      known[id] = *wanted;
      return id;
    }
    if (is_same(&known[id], wanted)) {
      return id;
    }
  }
  cf_library_fail("the code asks for more than 64 log variables and parameters by name");
}

static uint16_t id_of(bool is_log, const char *group, const char *name) {
  known_t wanted = {.is_log = is_log, .is_in_use = true};
  int     type;
  if (!cf_work_find(is_log, group, name, &wanted.distance, &type)) {
    return NO_ID;
  }
  wanted.type = (uint8_t)type;
  return know(&wanted);
}

static const known_t *known_as(bool is_log, uint16_t id) {
  const bool is_valid = id < MAX_KNOWN && known[id].is_in_use && known[id].is_log == is_log;
  return is_valid ? &known[id] : NULL;
}

// Names of nothing are empty, as an id that is not valid has them on the vehicle.
static void name(bool is_log, uint16_t id, char **group_of, char **name_of) {
  const known_t *variable = known_as(is_log, id);
  const char    *group    = "";
  const char    *own      = "";
  if (variable != NULL) {
    cf_work_name(is_log, variable->distance, &group, &own);
  }
  *group_of = (char *)(uintptr_t)group;
  *name_of  = (char *)(uintptr_t)own;
}

// ----------------------------------------------------------------------------------------- values

typedef union {
  uint8_t  u8;
  uint16_t u16;
  uint32_t u32;
  int8_t   i8;
  int16_t  i16;
  int32_t  i32;
  float    number;
} value_t;

static void *address_of(const known_t *variable) {
  void *address = cf_work_variable(variable->distance);
  if (variable->is_log) {
    cf_captured_refresh_log(address);
  }
  return address;
}

// Integers go through 32 signed bits, as on the vehicle.
static int get_int(const known_t *variable) {
  if (variable == NULL) {
    return 0;
  }
  value_t value;
  memcpy(&value, address_of(variable), cf_captured_size(variable->type));
  switch (variable->type) {
    case CF_TYPE_UINT8:
      return value.u8;
    case CF_TYPE_UINT16:
      return value.u16;
    case CF_TYPE_UINT32:
      return (int)value.u32;
    case CF_TYPE_INT8:
      return value.i8;
    case CF_TYPE_INT16:
      return value.i16;
    case CF_TYPE_INT32:
      return value.i32;
    default:
      return cf_to_int32(value.number);
  }
}

static float get_float(const known_t *variable) {
  if (variable == NULL || variable->type != CF_TYPE_FLOAT) {
    return (float)get_int(variable);
  }
  float number;
  memcpy(&number, address_of(variable), sizeof number);
  return number;
}

static void set(const known_t *variable, int integer, float number) {
  if (variable == NULL) {
    return;
  }
  value_t value;
  if (variable->type == CF_TYPE_FLOAT) {
    value.number = number;
  } else {
    value.i32 = integer;  // the low bytes are those of the smaller types
  }
  void *address = address_of(variable);
  memcpy(address, &value, cf_captured_size(variable->type));
  cf_captured_parameter_set(address);
}

// ------------------------------------------------------------------------------------------- log.h

WEAK logVarId_t logGetVarId(const char *group, const char *name) {
  return id_of(true, group, name);
}

WEAK int logGetType(logVarId_t varid) {
  const known_t *variable = known_as(true, varid);
  return variable != NULL ? variable->type + LOG_UINT8 : -1;
}

WEAK uint8_t logVarSize(int type) {
  return type == HALF_FLOAT ? 2 : (uint8_t)cf_captured_size(type - LOG_UINT8);
}

WEAK void *logGetAddress(logVarId_t varid) {
  const known_t *variable = known_as(true, varid);
  return variable != NULL ? address_of(variable) : NULL;
}

WEAK float logGetFloat(logVarId_t varid) {
  return get_float(known_as(true, varid));
}

WEAK int logGetInt(logVarId_t varid) {
  return get_int(known_as(true, varid));
}

WEAK unsigned int logGetUint(logVarId_t varid) {
  return (unsigned int)get_int(known_as(true, varid));
}

WEAK void logGetGroupAndName(logVarId_t varid, char **group_of, char **name_of) {
  name(true, varid, group_of, name_of);
}

// ----------------------------------------------------------------------------------------- param.h

// Wire types in the order of cf_type_t.
static const uint8_t PARAM_TYPES[] = {PARAM_UINT8, PARAM_UINT16, PARAM_UINT32, PARAM_INT8,
                                      PARAM_INT16, PARAM_INT32,  PARAM_FLOAT};

WEAK paramVarId_t paramGetVarId(const char *group, const char *name) {
  const uint16_t id = id_of(false, group, name);
  return (paramVarId_t){.index = id, .id = id};
}

#define LONGEST_GROUP 32

WEAK paramVarId_t paramGetVarIdFromComplete(const char *complete_name) {
  const char *dot    = strchr(complete_name, '.');
  size_t      length = dot != NULL ? (size_t)(dot - complete_name) : LONGEST_GROUP;
  if (length >= LONGEST_GROUP) {
    return (paramVarId_t){.index = NO_ID, .id = NO_ID};
  }
  char group[LONGEST_GROUP] = "";
  memcpy(group, complete_name, length);
  return paramGetVarId(group, dot + 1);
}

WEAK void paramGetGroupAndName(paramVarId_t varid, char **group_of, char **name_of) {
  name(false, varid.id, group_of, name_of);
}

WEAK int paramGetType(paramVarId_t varid) {
  const known_t *variable = known_as(false, varid.id);
  return variable != NULL ? PARAM_TYPES[variable->type] : -1;
}

WEAK uint8_t paramVarSize(int type) {
  return (uint8_t)(1 << (type & 0x03));
}

WEAK float paramGetFloat(paramVarId_t varid) {
  return get_float(known_as(false, varid.id));
}

WEAK int paramGetInt(paramVarId_t varid) {
  return get_int(known_as(false, varid.id));
}

WEAK unsigned int paramGetUint(paramVarId_t varid) {
  return (unsigned int)get_int(known_as(false, varid.id));
}

WEAK void paramSetInt(paramVarId_t varid, int value) {
  set(known_as(false, varid.id), value, (float)value);
}

WEAK void paramSetFloat(paramVarId_t varid, float value) {
  set(known_as(false, varid.id), cf_to_int32(value), value);
}
