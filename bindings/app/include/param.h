/* The firmware's param.h for apps: types, flags and functions. What PARAM_* declares is caught by
 * library/include/tables.h.
 *
 * Types and flags are those of the firmware's tables (docs/reference/crtp-cflib.md#9.1). */
#ifndef CF_APP_PARAM_H
#define CF_APP_PARAM_H

#include <stdbool.h>
#include <stdint.h>

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

// ----------------------------------------------------------------------------- reading and writing

// Any parameter of the same drone, those of the simulation included.
typedef struct {
  uint16_t id;
  uint16_t index;
} __attribute__((packed)) paramVarId_t;

#define PARAM_VARID_IS_VALID(varId) ((varId).id != 0xffffu)

paramVarId_t paramGetVarId(const char *group, const char *name);
paramVarId_t paramGetVarIdFromComplete(const char *complete_name);  // "group.name"
int          paramGetType(paramVarId_t varid);
void         paramGetGroupAndName(paramVarId_t varid, char **group, char **name);
uint8_t      paramVarSize(int type);
float        paramGetFloat(paramVarId_t varid);
int          paramGetInt(paramVarId_t varid);
unsigned int paramGetUint(paramVarId_t varid);

// What a client may not write, code may. Callbacks are run.
void paramSetInt(paramVarId_t varid, int value);
void paramSetFloat(paramVarId_t varid, float value);

#include "library/include/tables.h"

#endif  // CF_APP_PARAM_H
