/* Stands in for the firmware's param.h: the same macros and functions, but what PARAM_* declares
 * goes into the section that ../captured.h describes.
 *
 * Types and flags are those of the firmware's tables (crtp-cflib dossier section 9.1). */
#ifndef CF_LIBRARY_PARAM_H
#define CF_LIBRARY_PARAM_H

// the guards of the firmware's own header, which has nothing to add
#define __PARAM_H__
#define _PARAM_H_
#define PARAM_H_
#define PARAM_H

#include <stdbool.h>
#include <stdint.h>

#include "../../variables.h"
#include "../captured.h"

#define PARAM_1BYTE 0x00
#define PARAM_2BYTES 0x01
#define PARAM_4BYTES 0x02
#define PARAM_8BYTES 0x03
#define PARAM_BYTES_MASK 0x03

#define PARAM_TYPE_INT (0x00 << 2)
#define PARAM_TYPE_FLOAT (0x01 << 2)
#define PARAM_SIGNED (0x00 << 3)
#define PARAM_UNSIGNED (0x01 << 3)

#define PARAM_UINT8 (PARAM_1BYTE | PARAM_TYPE_INT | PARAM_UNSIGNED)
#define PARAM_INT8 (PARAM_1BYTE | PARAM_TYPE_INT | PARAM_SIGNED)
#define PARAM_UINT16 (PARAM_2BYTES | PARAM_TYPE_INT | PARAM_UNSIGNED)
#define PARAM_INT16 (PARAM_2BYTES | PARAM_TYPE_INT | PARAM_SIGNED)
#define PARAM_UINT32 (PARAM_4BYTES | PARAM_TYPE_INT | PARAM_UNSIGNED)
#define PARAM_INT32 (PARAM_4BYTES | PARAM_TYPE_INT | PARAM_SIGNED)
#define PARAM_FLOAT (PARAM_4BYTES | PARAM_TYPE_FLOAT | PARAM_SIGNED)

#define PARAM_TYPE_MASK 0x0f
#define PARAM_STOP 0
#define PARAM_START 1
#define PARAM_EXTENDED (1 << 4)
#define PARAM_CORE (1 << 5)
#define PARAM_RONLY (1 << 6)
#define PARAM_GROUP (1 << 7)
#define PARAM_PERSISTENT (1 << 8)

// -------------------------------------------------------------------------------- declarations

#define CF_PARAM_NO_TYPE 0xff
#define CF_PARAM_TYPE(type_)                                          \
  (((type_) & PARAM_TYPE_MASK) == PARAM_UINT8    ? CF_TYPE_UINT8      \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_UINT16 ? CF_TYPE_UINT16     \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_UINT32 ? CF_TYPE_UINT32     \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_INT8   ? CF_TYPE_INT8       \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_INT16  ? CF_TYPE_INT16      \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_INT32  ? CF_TYPE_INT32      \
   : ((type_) & PARAM_TYPE_MASK) == PARAM_FLOAT  ? (int)CF_TYPE_FLOAT \
                                                 : CF_PARAM_NO_TYPE)
#define CF_PARAM_FLAGS(type_)                                \
  ((((type_) & PARAM_CORE) != 0 ? CF_CORE : 0) |             \
   (((type_) & PARAM_PERSISTENT) != 0 ? CF_PERSISTENT : 0) | \
   (((type_) & PARAM_RONLY) != 0 ? CF_READ_ONLY : 0))

// The name comes as a string, made where nobody has looked yet whether it is a macro.
#define CF_PARAM_ROW(type_, name_, address_, callback_) \
  {.kind     = CF_CAPTURED_VARIABLE,                    \
   .type     = (uint8_t)CF_PARAM_TYPE(type_),           \
   .flags    = (uint8_t)CF_PARAM_FLAGS(type_),          \
   .name     = (name_),                                 \
   .address  = (void *)(address_),                      \
   .callback = (callback_)},

#define PARAM_ADD(TYPE, NAME, ADDRESS) CF_PARAM_ROW(TYPE, #NAME, ADDRESS, 0)
#define PARAM_ADD_CORE(TYPE, NAME, ADDRESS) CF_PARAM_ROW((TYPE) | PARAM_CORE, #NAME, ADDRESS, 0)
#define PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  CF_PARAM_ROW(TYPE, #NAME, ADDRESS, CALLBACK)
#define PARAM_ADD_CORE_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  CF_PARAM_ROW((TYPE) | PARAM_CORE, #NAME, ADDRESS, CALLBACK)
// The getter of a default is not asked: the default is what the parameter is after boot.
#define PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, DEFAULT_GETTER) \
  CF_PARAM_ROW(TYPE, #NAME, ADDRESS, CALLBACK)

#define PARAM_GROUP_START(NAME)                                                \
  static const cf_captured_t cf_parameters_##NAME[] CF_CAPTURED_PARAMETERS = { \
      {.kind = CF_CAPTURED_GROUP, .name = #NAME},
#define PARAM_GROUP_STOP(NAME) \
  }                            \
  ;

// ----------------------------------------------------------------------------- reading and writing

// Any parameter of the same drone, those of the simulation included.
typedef struct {
  uint16_t index;
  uint16_t id;
} __attribute__((packed)) paramVarId_t;

#define PARAM_VARID_IS_VALID(varId) ((varId).id != 0xffffu)

paramVarId_t paramGetVarId(const char *group, const char *name);
int          paramGetType(paramVarId_t varid);
uint8_t      paramVarSize(int type);
float        paramGetFloat(paramVarId_t varid);
int          paramGetInt(paramVarId_t varid);
unsigned int paramGetUint(paramVarId_t varid);

// What a client may not write, code may. Callbacks are run.
void paramSetInt(paramVarId_t varid, int value);
void paramSetFloat(paramVarId_t varid, float value);

#endif  // CF_LIBRARY_PARAM_H
