/* Parameters and log variables as PARAM_* and LOG_* of compiled firmware sources declare them.
 *
 * The macros of include/tables.h put rows of this form into a section of their own; the library
 * reads them when it is opened. */
#ifndef CF_LIBRARY_CAPTURED_H
#define CF_LIBRARY_CAPTURED_H

#include <stdint.h>

typedef enum {
  CF_CAPTURED_NOTHING  = 0,  // fills gaps between tables
  CF_CAPTURED_GROUP    = 1,  // `name` opens a group
  CF_CAPTURED_VARIABLE = 2,
  CF_CAPTURED_BY_FUNCTION =
      3,  // a log variable that is computed: `address` is the firmware's logByFunction_t
} cf_captured_kind_t;

// 32 bytes on every host with 64 bits, so that tables of different files follow without gaps.
typedef struct {
  uint8_t     kind;   // cf_captured_kind_t
  uint8_t     type;   // cf_type_t
  uint8_t     flags;  // CF_CORE | CF_PERSISTENT | CF_READ_ONLY
  uint8_t     reserved;
  uint32_t    reserved2;
  const char *name;
  void       *address;
  void (*callback)(void);  // of a parameter, called after it was written; or null
} cf_captured_t;

#define CF_CAPTURED_PARAMETERS __attribute__((section("cf_parameters"), used, aligned(32)))
#define CF_CAPTURED_LOGS __attribute__((section("cf_logs"), used, aligned(32)))

#endif  // CF_LIBRARY_CAPTURED_H
