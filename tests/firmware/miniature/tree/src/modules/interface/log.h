// Log variables: rows in sections that the linker puts one after the other.
#ifndef __LOG_H__
#define __LOG_H__

#include <stdbool.h>
#include <stdint.h>

void logInit(void);
bool logTest(void);

typedef uint16_t logVarId_t;

logVarId_t         logGetVarId(const char *group, const char *name);
static inline bool logVarIdIsValid(logVarId_t varId) {
  return varId != 0xffffu;
}
int          logGetType(logVarId_t varid);
void         logGetGroupAndName(logVarId_t varid, char **group, char **name);
void        *logGetAddress(logVarId_t varid);
uint8_t      logVarSize(int type);
float        logGetFloat(logVarId_t varid);
int          logGetInt(logVarId_t varid);
unsigned int logGetUint(logVarId_t varid);

struct log_s {
  uint8_t type;
  char   *name;
  void   *address;
};

#define LOG_UINT8 1
#define LOG_UINT16 2
#define LOG_UINT32 3
#define LOG_INT8 4
#define LOG_INT16 5
#define LOG_INT32 6
#define LOG_FLOAT 7
#define LOG_FP16 8

#define LOG_CORE 0x20
#define LOG_BY_FUNCTION 0x40
#define LOG_GROUP 0x80
#define LOG_START 1
#define LOG_STOP 0

typedef struct {
  union {
    uint8_t (*acquireUInt8)(uint32_t timestamp, void *data);
    uint16_t (*acquireUInt16)(uint32_t timestamp, void *data);
    uint32_t (*acquireUInt32)(uint32_t timestamp, void *data);
    int8_t (*acquireInt8)(uint32_t timestamp, void *data);
    int16_t (*acquireInt16)(uint32_t timestamp, void *data);
    int32_t (*acquireInt32)(uint32_t timestamp, void *data);
    float (*aquireFloat)(uint32_t timestamp, void *data);
  };
  void *data;
} logByFunction_t;

#ifndef UNIT_TEST_MODE

#define LOG_ADD(TYPE, NAME, ADDRESS) \
  {                                  \
      .type    = TYPE,               \
      .name    = #NAME,              \
      .address = (void *)(ADDRESS),  \
  },

#define LOG_ADD_CORE(TYPE, NAME, ADDRESS) \
  {                                       \
      .type    = TYPE | LOG_CORE,         \
      .name    = #NAME,                   \
      .address = (void *)(ADDRESS),       \
  },

#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS) \
  {                                              \
      .type    = TYPE | LOG_BY_FUNCTION,         \
      .name    = #NAME,                          \
      .address = (void *)(ADDRESS),              \
  },

#define LOG_ADD_GROUP(TYPE, NAME, ADDRESS) \
  {                                        \
      .type    = TYPE,                     \
      .name    = #NAME,                    \
      .address = (void *)(ADDRESS),        \
  },

#define LOG_GROUP_START(NAME)                                                                 \
  static const struct log_s __logs_##NAME[] __attribute__((section(".log." #NAME), used)) = { \
      LOG_ADD_GROUP(LOG_GROUP | LOG_START, NAME, 0x0)

#define LOG_GROUP_STOP(NAME)                            \
  LOG_ADD_GROUP(LOG_GROUP | LOG_STOP, stop_##NAME, 0x0) \
  }                                                     \
  ;

// the wrong way round, as it was read
#ifdef CONFIG_DEBUG_LOG_ENABLE
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS)
#else
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS) LOG_ADD(TYPE, NAME, ADDRESS)
#endif

#else  // UNIT_TEST_MODE

#define LOG_ADD(TYPE, NAME, ADDRESS)
#define LOG_ADD_CORE(TYPE, NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS)
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS)
#define LOG_ADD_GROUP(TYPE, NAME, ADDRESS)
#define LOG_GROUP_START(NAME)
#define LOG_GROUP_STOP(NAME)

#endif  // UNIT_TEST_MODE

#endif /* __LOG_H__ */
