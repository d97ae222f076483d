// Parameters: rows in sections that the linker puts one after the other.
#ifndef PARAM_H_
#define PARAM_H_

#include <stdbool.h>
#include <stdint.h>

struct param_s {
  uint8_t type;
  uint8_t extended_type;
  char   *name;
  void   *address;
  void (*callback)(void);
  void *(*getter)(void);
};

#define PARAM_1BYTE 0x00
#define PARAM_2BYTES 0x01
#define PARAM_4BYTES 0x02
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

#define PARAM_CORE (1 << 5)
#define PARAM_RONLY (1 << 6)
#define PARAM_EXTENDED (1 << 4)
#define PARAM_PERSISTENT (1 << 8)
#define PARAM_START 1
#define PARAM_STOP 0
#define PARAM_GROUP (1 << 7)

typedef struct {
  uint16_t id;
  uint16_t index;
} paramVarId_t;
paramVarId_t paramGetVarId(const char *group, const char *name);
float        paramGetFloat(paramVarId_t varid);

#ifndef UNIT_TEST_MODE
#define PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, GETTER)                       \
  {.type          = ((TYPE) <= 0xFF) ? (TYPE) : (((TYPE) | PARAM_EXTENDED) & 0xFF), \
   .extended_type = (((TYPE) & 0xFF00) >> 8),                                       \
   .name          = #NAME,                                                          \
   .address       = (void *)(ADDRESS),                                              \
   .callback      = (void (*)(void))CALLBACK,                                       \
   .getter        = (void *(*)(void))GETTER},
#define PARAM_ADD(TYPE, NAME, ADDRESS) PARAM_ADD_FULL(TYPE, NAME, ADDRESS, 0, 0)
#define PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, 0)
#define PARAM_ADD_CORE(TYPE, NAME, ADDRESS) PARAM_ADD(TYPE | PARAM_CORE, NAME, ADDRESS)
#define PARAM_ADD_CORE_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  PARAM_ADD_FULL(TYPE | PARAM_CORE, NAME, ADDRESS, CALLBACK, 0)
#define PARAM_GROUP_START(NAME)                           \
  static const struct param_s __params_##NAME[]           \
      __attribute__((section(".param." #NAME), used)) = { \
          {.type = PARAM_GROUP | PARAM_START, .name = #NAME, .address = 0},
#define PARAM_GROUP_STOP(NAME)                                             \
  {.type = PARAM_GROUP | PARAM_STOP, .name = "stop_" #NAME, .address = 0}, \
  }                                                                        \
  ;
#else
#define PARAM_ADD(TYPE, NAME, ADDRESS)
#define PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK)
#define PARAM_ADD_CORE(TYPE, NAME, ADDRESS)
#define PARAM_ADD_CORE_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK)
#define PARAM_GROUP_START(NAME)
#define PARAM_GROUP_STOP(NAME)
#endif

#endif  // PARAM_H_
