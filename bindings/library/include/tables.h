/* Catches what PARAM_* and LOG_* declare: only the macros that make rows of tables are ours.
 *
 * Comes after log.h and param.h, whose own rows the linker script of the vehicle would collect.
 * Types, flags, prototypes and everything else stay as those headers have them, so that it does not
 * matter how a release words them. Their guards keep both headers from coming back, wherever they
 * are included from. The rows go into the sections that ../captured.h describes. */
#ifndef CF_LIBRARY_TABLES_H
#define CF_LIBRARY_TABLES_H

#include "../../variables.h"
#include "../captured.h"

// ------------------------------------------------------------------------------------- parameters

#undef PARAM_ADD_FULL
#undef PARAM_ADD
#undef PARAM_ADD_WITH_CALLBACK
#undef PARAM_ADD_CORE
#undef PARAM_ADD_CORE_WITH_CALLBACK
#undef PARAM_ADD_PERSISTENT
#undef PARAM_ADD_GROUP
#undef PARAM_GROUP_START
#undef PARAM_GROUP_STOP

// flags that old releases do not have
#ifndef PARAM_CORE
#define PARAM_CORE (1 << 5)
#endif
#ifndef PARAM_PERSISTENT
#define PARAM_PERSISTENT (1 << 8)
#endif

#define CF_PARAM_TYPE_MASK 0x0f
#define CF_PARAM_NO_TYPE 0xff
#define CF_PARAM_TYPE(type_)                                             \
  (((type_) & CF_PARAM_TYPE_MASK) == PARAM_UINT8    ? CF_TYPE_UINT8      \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_UINT16 ? CF_TYPE_UINT16     \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_UINT32 ? CF_TYPE_UINT32     \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_INT8   ? CF_TYPE_INT8       \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_INT16  ? CF_TYPE_INT16      \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_INT32  ? CF_TYPE_INT32      \
   : ((type_) & CF_PARAM_TYPE_MASK) == PARAM_FLOAT  ? (int)CF_TYPE_FLOAT \
                                                    : CF_PARAM_NO_TYPE)
#define CF_PARAM_FLAGS(type_)                                \
  ((((type_) & PARAM_CORE) != 0 ? CF_CORE : 0) |             \
   (((type_) & PARAM_PERSISTENT) != 0 ? CF_PERSISTENT : 0) | \
   (((type_) & PARAM_RONLY) != 0 ? CF_READ_ONLY : 0))

// The getter of a default is not asked: the default is what the parameter is after boot. As on the
// vehicle, a name that is a macro is expanded, except with this macro itself.
#define PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, DEFAULT_GETTER) \
  {.kind     = CF_CAPTURED_VARIABLE,                                  \
   .type     = (uint8_t)CF_PARAM_TYPE(TYPE),                          \
   .flags    = (uint8_t)CF_PARAM_FLAGS(TYPE),                         \
   .name     = #NAME,                                                 \
   .address  = (void *)(ADDRESS),                                     \
   .callback = (void (*)(void))(CALLBACK)},
#define PARAM_ADD(TYPE, NAME, ADDRESS) PARAM_ADD_FULL(TYPE, NAME, ADDRESS, 0, 0)
#define PARAM_ADD_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  PARAM_ADD_FULL(TYPE, NAME, ADDRESS, CALLBACK, 0)
#define PARAM_ADD_CORE(TYPE, NAME, ADDRESS) PARAM_ADD_FULL((TYPE) | PARAM_CORE, NAME, ADDRESS, 0, 0)
#define PARAM_ADD_CORE_WITH_CALLBACK(TYPE, NAME, ADDRESS, CALLBACK) \
  PARAM_ADD_FULL((TYPE) | PARAM_CORE, NAME, ADDRESS, CALLBACK, 0)
// in releases of 2021 only
#define PARAM_ADD_PERSISTENT(TYPE, NAME, ADDRESS, CALLBACK) \
  PARAM_ADD_FULL((TYPE) | PARAM_PERSISTENT, NAME, ADDRESS, CALLBACK, 0)
#define PARAM_ADD_GROUP(TYPE, NAME, ADDRESS) {.kind = CF_CAPTURED_NOTHING},

#define PARAM_GROUP_START(NAME)                                                \
  static const cf_captured_t cf_parameters_##NAME[] CF_CAPTURED_PARAMETERS = { \
      {.kind = CF_CAPTURED_GROUP, .name = #NAME},
#define PARAM_GROUP_STOP(NAME) \
  }                            \
  ;

// ---------------------------------------------------------------------------------- log variables

#undef LOG_ADD
#undef LOG_ADD_CORE
#undef LOG_ADD_BY_FUNCTION
#undef LOG_ADD_CORE_BY_FUNCTION
#undef LOG_ADD_GROUP
#undef LOG_GROUP_START
#undef LOG_GROUP_STOP

#ifndef LOG_CORE
#define LOG_CORE 0x20
#endif
#ifndef LOG_BY_FUNCTION
#define LOG_BY_FUNCTION 0x40
#endif
#define CF_LOG_TYPE_MASK 0x0f

// LOG_UINT8 is 1 where CF_TYPE_UINT8 is 0, and so on; what is no type stays none.
#define CF_LOG_ROW(type_, name_, address_)                                         \
  {.kind    = (uint8_t)(((type_) & LOG_BY_FUNCTION) != 0 ? CF_CAPTURED_BY_FUNCTION \
                                                         : CF_CAPTURED_VARIABLE),  \
   .type    = (uint8_t)(((type_) & CF_LOG_TYPE_MASK) - 1),                         \
   .flags   = (uint8_t)(((type_) & LOG_CORE) != 0 ? CF_CORE : 0),                  \
   .name    = (name_),                                                             \
   .address = (void *)(address_)},

#define LOG_ADD(TYPE, NAME, ADDRESS) CF_LOG_ROW(TYPE, #NAME, ADDRESS)
#define LOG_ADD_CORE(TYPE, NAME, ADDRESS) CF_LOG_ROW((TYPE) | LOG_CORE, #NAME, ADDRESS)
#define LOG_ADD_BY_FUNCTION(TYPE, NAME, ADDRESS) \
  CF_LOG_ROW((TYPE) | LOG_BY_FUNCTION, #NAME, ADDRESS)
#define LOG_ADD_CORE_BY_FUNCTION(TYPE, NAME, ADDRESS) \
  CF_LOG_ROW((TYPE) | LOG_CORE | LOG_BY_FUNCTION, #NAME, ADDRESS)
#define LOG_ADD_GROUP(TYPE, NAME, ADDRESS) {.kind = CF_CAPTURED_NOTHING},

// for developers; where log.h has this macro, it decides when there is a row
#ifndef LOG_ADD_DEBUG
#define LOG_ADD_DEBUG(TYPE, NAME, ADDRESS) LOG_ADD(TYPE, NAME, ADDRESS)
#endif

#define LOG_GROUP_START(NAME)                                      \
  static const cf_captured_t cf_logs_##NAME[] CF_CAPTURED_LOGS = { \
      {.kind = CF_CAPTURED_GROUP, .name = #NAME},
#define LOG_GROUP_STOP(NAME) \
  }                          \
  ;

#endif  // CF_LIBRARY_TABLES_H
