/* Stands in for the firmware's log.h: the same macros and functions, but what LOG_* declares goes
 * into the section that ../captured.h describes.
 *
 * Types and flags are those of the firmware's tables (crtp-cflib dossier section 8.1). */
#ifndef CF_LIBRARY_LOG_H
#define CF_LIBRARY_LOG_H

// the guards of the firmware's own header, which has nothing to add
#define __LOG_H__
#define _LOG_H_
#define LOG_H_
#define LOG_H

#include <stdbool.h>
#include <stdint.h>

#include "../../variables.h"
#include "../captured.h"

#define LOG_UINT8 1
#define LOG_UINT16 2
#define LOG_UINT32 3
#define LOG_INT8 4
#define LOG_INT16 5
#define LOG_INT32 6
#define LOG_FLOAT 7
#define LOG_FP16 8  // only to fetch as, never to declare

#define LOG_TYPE_MASK 0x0f
#define LOG_STOP 0
#define LOG_START 1
#define LOG_CORE 0x20
#define LOG_BY_FUNCTION 0x40
#define LOG_GROUP 0x80

// -------------------------------------------------------------------------- computed variables

typedef uint8_t (*logAcquireUInt8)(uint32_t timestamp, void *data);
typedef uint16_t (*logAcquireUInt16)(uint32_t timestamp, void *data);
typedef uint32_t (*logAcquireUInt32)(uint32_t timestamp, void *data);
typedef int8_t (*logAcquireInt8)(uint32_t timestamp, void *data);
typedef int16_t (*logAcquireInt16)(uint32_t timestamp, void *data);
typedef int32_t (*logAcquireInt32)(uint32_t timestamp, void *data);
typedef float (*logAcquireFloat)(uint32_t timestamp, void *data);

typedef struct {
  union {
    logAcquireUInt8  acquireUInt8;
    logAcquireUInt16 acquireUInt16;
    logAcquireUInt32 acquireUInt32;
    logAcquireInt8   acquireInt8;
    logAcquireInt16  acquireInt16;
    logAcquireInt32  acquireInt32;
    logAcquireFloat  acquireFloat;
    logAcquireFloat  aquireFloat;  // as the firmware spells it
  };
  void *data;
} logByFunction_t;

// -------------------------------------------------------------------------------- declarations

// LOG_UINT8 is 1 where CF_TYPE_UINT8 is 0, and so on; what is no type stays none. The name comes as
// a string, made where nobody has looked yet whether it is a macro.
#define CF_LOG_ROW(type_, name_, address_)                                         \
  {.kind    = (uint8_t)(((type_) & LOG_BY_FUNCTION) != 0 ? CF_CAPTURED_BY_FUNCTION \
                                                         : CF_CAPTURED_VARIABLE),  \
   .type    = (uint8_t)(((type_) & LOG_TYPE_MASK) - 1),                            \
   .flags   = (uint8_t)(((type_) & LOG_CORE) != 0 ? CF_CORE : 0),                  \
   .name    = (name_),                                                             \
   .address = (void *)(address_)},

#define LOG_ADD(TYPE, NAME, ADDRESS) CF_LOG_ROW(TYPE, #NAME, ADDRESS)
#define LOG_ADD_CORE(TYPE, NAME, ADDRESS) CF_LOG_ROW((TYPE) | LOG_CORE, #NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS) \
  CF_LOG_ROW((TYPE) | LOG_BY_FUNCTION, #NAME, ADDRESS)
#define LOG_ADD_CORE_BY_FUNCTION(TYPE, NAME, ADDRESS) \
  CF_LOG_ROW((TYPE) | LOG_CORE | LOG_BY_FUNCTION, #NAME, ADDRESS)

// for developers, who ask for it when they build
#ifdef CONFIG_DEBUG_LOG_ENABLE
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS) CF_LOG_ROW(TYPE, #NAME, ADDRESS)
#else
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS)
#endif

#define LOG_GROUP_START(NAME)                                      \
  static const cf_captured_t cf_logs_##NAME[] CF_CAPTURED_LOGS = { \
      {.kind = CF_CAPTURED_GROUP, .name = #NAME},
#define LOG_GROUP_STOP(NAME) \
  }                          \
  ;

// ------------------------------------------------------------------------------------ reading

// Any log variable of the same drone, those of the simulation included.
typedef uint16_t logVarId_t;

#define LOG_VARID_IS_VALID(varId) ((varId) != 0xffffu)

logVarId_t   logGetVarId(const char *group, const char *name);
int          logGetType(logVarId_t varid);
uint8_t      logVarSize(int type);
void        *logGetAddress(logVarId_t varid);
float        logGetFloat(logVarId_t varid);
int          logGetInt(logVarId_t varid);
unsigned int logGetUint(logVarId_t varid);

static inline bool logVarIdIsValid(logVarId_t varId) {
  return LOG_VARID_IS_VALID(varId);
}

#endif  // CF_LIBRARY_LOG_H
