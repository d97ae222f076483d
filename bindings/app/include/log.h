/* The firmware's log.h for apps: types, flags and functions. What LOG_* declares is caught by
 * library/include/tables.h.
 *
 * Types and flags are those of the firmware's tables (docs/reference/crtp-cflib.md#8.1). */
#ifndef CF_APP_LOG_H
#define CF_APP_LOG_H

#include <stdbool.h>
#include <stdint.h>

#define LOG_UINT8 1
#define LOG_UINT16 2
#define LOG_UINT32 3
#define LOG_INT8 4
#define LOG_INT16 5
#define LOG_INT32 6
#define LOG_FLOAT 7
#define LOG_FP16 8  // only to fetch as, never to declare

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
void         logGetGroupAndName(logVarId_t varid, char **group, char **name);

static inline bool logVarIdIsValid(logVarId_t varId) {
  return LOG_VARID_IS_VALID(varId);
}

// for developers; as the firmware has it
#ifdef CONFIG_DEBUG_LOG_ENABLE
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS)
#endif

#include "library/include/tables.h"

#endif  // CF_APP_LOG_H
