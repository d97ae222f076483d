// Events with a payload, for recorders.
#ifndef __EVENTTRIGGER_H__
#define __EVENTTRIGGER_H__

#include <stdbool.h>
#include <stdint.h>

enum eventtriggerType_e {
  eventtriggerType_uint8  = 1,
  eventtriggerType_uint16 = 2,
  eventtriggerType_uint32 = 3,
  eventtriggerType_int8   = 4,
  eventtriggerType_int16  = 5,
  eventtriggerType_int32  = 6,
  eventtriggerType_float  = 7,
  eventtriggerType_fp16   = 8,
};

typedef struct {
  const char             *name;
  enum eventtriggerType_e type;
} eventtriggerPayloadDesc;

enum eventtriggerHandler_e {
  eventtriggerHandler_USD = 0,
  eventtriggerHandler_Count,
};

typedef struct eventtrigger_s {
  const char                    *name;
  const eventtriggerPayloadDesc *payloadDesc;
  uint8_t                        numPayloadVariables;
  void                          *payload;
  uint8_t                        payloadSize;
} eventtrigger;

typedef void (*eventtriggerCallback)(const eventtrigger *event);

uint16_t            eventtriggerGetId(const eventtrigger *event);
const eventtrigger *eventtriggerGetById(uint16_t id);
const eventtrigger *eventtriggerGetByName(const char *name);
void eventtriggerRegisterCallback(enum eventtriggerHandler_e handler, eventtriggerCallback cb);
void eventTrigger(const eventtrigger *event);

#ifndef UNIT_TEST_MODE

// how many arguments come in pairs, up to five of them
#define EVENTTRIGGER_PICK(_0, _1, _2, _3, _4, _5, _6, _7, _8, _9, _10, NAME, ...) NAME
#define EVENTTRIGGER_COUNT(...) \
  EVENTTRIGGER_PICK(_0, ##__VA_ARGS__, 5, 5, 4, 4, 3, 3, 2, 2, 1, 1, 0)
#define EVENTTRIGGER_JOIN_(A, B) A##B
#define EVENTTRIGGER_JOIN(A, B) EVENTTRIGGER_JOIN_(A, B)

#define EVENTTRIGGER_FIELDS_0(...)
#define EVENTTRIGGER_FIELDS_1(T, F) EVENTTRIGGER_CTYPE_##T F;
#define EVENTTRIGGER_FIELDS_2(T, F, ...) \
  EVENTTRIGGER_CTYPE_##T F;              \
  EVENTTRIGGER_FIELDS_1(__VA_ARGS__)
#define EVENTTRIGGER_FIELDS_3(T, F, ...) \
  EVENTTRIGGER_CTYPE_##T F;              \
  EVENTTRIGGER_FIELDS_2(__VA_ARGS__)
#define EVENTTRIGGER_FIELDS_4(T, F, ...) \
  EVENTTRIGGER_CTYPE_##T F;              \
  EVENTTRIGGER_FIELDS_3(__VA_ARGS__)
#define EVENTTRIGGER_FIELDS_5(T, F, ...) \
  EVENTTRIGGER_CTYPE_##T F;              \
  EVENTTRIGGER_FIELDS_4(__VA_ARGS__)

#define EVENTTRIGGER_DESCS_0(...)
#define EVENTTRIGGER_DESCS_1(T, F) {.name = #F, .type = eventtriggerType_##T},
#define EVENTTRIGGER_DESCS_2(T, F, ...) EVENTTRIGGER_DESCS_1(T, F) EVENTTRIGGER_DESCS_1(__VA_ARGS__)
#define EVENTTRIGGER_DESCS_3(T, F, ...) EVENTTRIGGER_DESCS_1(T, F) EVENTTRIGGER_DESCS_2(__VA_ARGS__)
#define EVENTTRIGGER_DESCS_4(T, F, ...) EVENTTRIGGER_DESCS_1(T, F) EVENTTRIGGER_DESCS_3(__VA_ARGS__)
#define EVENTTRIGGER_DESCS_5(T, F, ...) EVENTTRIGGER_DESCS_1(T, F) EVENTTRIGGER_DESCS_4(__VA_ARGS__)

#define EVENTTRIGGER_CTYPE_uint8 uint8_t
#define EVENTTRIGGER_CTYPE_uint16 uint16_t
#define EVENTTRIGGER_CTYPE_uint32 uint32_t
#define EVENTTRIGGER_CTYPE_int8 int8_t
#define EVENTTRIGGER_CTYPE_int16 int16_t
#define EVENTTRIGGER_CTYPE_int32 int32_t
#define EVENTTRIGGER_CTYPE_float float
#define EVENTTRIGGER_CTYPE_fp16 uint16_t

#define EVENTTRIGGER(NAME, ...)                                                                    \
  static struct {                                                                                  \
    EVENTTRIGGER_JOIN(EVENTTRIGGER_FIELDS_, EVENTTRIGGER_COUNT(__VA_ARGS__))(__VA_ARGS__)          \
  } __attribute__((packed))            eventTrigger_##NAME##_payload;                              \
  static const eventtriggerPayloadDesc eventTrigger_##NAME##_desc[] = {                            \
      EVENTTRIGGER_JOIN(EVENTTRIGGER_DESCS_, EVENTTRIGGER_COUNT(__VA_ARGS__))(__VA_ARGS__)};       \
  static eventtrigger eventTrigger_##NAME __attribute__((section(".eventtrigger." #NAME),          \
                                                         used)) = {                                \
      .name                = #NAME,                                                                \
      .payloadDesc         = eventTrigger_##NAME##_desc,                                           \
      .numPayloadVariables = sizeof(eventTrigger_##NAME##_desc) / sizeof(eventtriggerPayloadDesc), \
      .payload             = &eventTrigger_##NAME##_payload,                                       \
      .payloadSize         = sizeof(eventTrigger_##NAME##_payload)};

#else

#define EVENTTRIGGER(NAME, ...)

#endif

#endif  // __EVENTTRIGGER_H__
