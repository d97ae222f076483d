// Log variables: rows in sections that the linker puts one after the other.
#ifndef LOG_H_
#define LOG_H_

#include <stdbool.h>
#include <stdint.h>

typedef float (*logAcquireFloat)(uint32_t timestamp, void *data);
typedef struct {
  logAcquireFloat acquireFloat;
  void           *data;
} logByFunction_t;

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
#define LOG_CORE (1 << 5)
#define LOG_BY_FUNCTION (1 << 6)
#define LOG_GROUP 0x80
#define LOG_START 1
#define LOG_STOP 0

typedef uint16_t logVarId_t;
logVarId_t       logGetVarId(const char *group, const char *name);
float            logGetFloat(logVarId_t varid);

#ifndef UNIT_TEST_MODE
#define LOG_ADD(TYPE, NAME, ADDRESS) {.type = TYPE, .name = #NAME, .address = (void *)(ADDRESS)},
#define LOG_ADD_CORE(TYPE, NAME, ADDRESS) LOG_ADD(TYPE | LOG_CORE, NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS) LOG_ADD(TYPE | LOG_BY_FUNCTION, NAME, ADDRESS)
#define LOG_GROUP_START(NAME)                                                                 \
  static const struct log_s __logs_##NAME[] __attribute__((section(".log." #NAME), used)) = { \
      {.type = LOG_GROUP | LOG_START, .name = #NAME, .address = 0},
#define LOG_GROUP_STOP(NAME)                                           \
  {.type = LOG_GROUP | LOG_STOP, .name = "stop_" #NAME, .address = 0}, \
  }                                                                    \
  ;
#else
#define LOG_ADD(TYPE, NAME, ADDRESS)
#define LOG_ADD_CORE(TYPE, NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS)
#define LOG_GROUP_START(NAME)
#define LOG_GROUP_STOP(NAME)
#endif

#endif  // LOG_H_
