// Parameters by name, and what the packets of their port do.
#pragma once

#include <stdbool.h>
#include <stdint.h>
// clang-format off: read from the first folder that has them
#include <param.h>
#include <crtp.h>
// clang-format on

typedef struct paramVarId_s {
  uint16_t id;
  uint16_t index;
} __attribute__((packed)) paramVarId_t;

#define PARAM_VARID_IS_VALID(varId) (varId.id != 0xffffu)

void paramLogicInit();
void paramLogicStorageInit();

paramVarId_t paramGetVarId(const char *group, const char *name);
paramVarId_t paramGetVarIdFromComplete(const char *completeName);

int     paramGetType(paramVarId_t varid);
void    paramGetGroupAndName(paramVarId_t varid, char **group, char **name);
uint8_t paramVarSize(int type);

float        paramGetFloat(paramVarId_t varid);
int          paramGetInt(paramVarId_t varid);
unsigned int paramGetUint(paramVarId_t varid);
void         paramSetInt(paramVarId_t varid, int valuei);
void         paramSetFloat(paramVarId_t varid, float valuef);

void paramWriteProcess(CRTPPacket *p);
void paramReadProcess(CRTPPacket *p);
void paramTOCProcess(CRTPPacket *p, int command);
void paramSetByName(CRTPPacket *p);
void paramGetExtendedType(CRTPPacket *p);
void paramGetDefaultValue(CRTPPacket *p);
void paramPersistentStore(CRTPPacket *p);
void paramPersistentGetState(CRTPPacket *p);
void paramPersistentClear(CRTPPacket *p);
