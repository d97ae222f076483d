/* How a table of variables is written: CF_ROW(group, name, FLOAT, flags, struct type, member).
 * Internal to C. */
#ifndef CF_VARIABLE_ROW_H
#define CF_VARIABLE_ROW_H

#include <stddef.h>

#include "variables.h"

// the member's size is checked against the declared type at compile time
#define CF_SIZE_UINT8 1
#define CF_SIZE_UINT16 2
#define CF_SIZE_UINT32 4
#define CF_SIZE_INT8 1
#define CF_SIZE_INT16 2
#define CF_SIZE_INT32 4
#define CF_SIZE_FLOAT 4

#define CF_CHECKED_OFFSET(type_, struct_, member_) \
  (uint32_t)(offsetof(struct_, member_) +          \
             0 * sizeof(char[sizeof(((struct_ *)0)->member_) == CF_SIZE_##type_ ? 1 : -1]))

#define CF_ROW(group_, name_, type_, flags_, struct_, member_) \
  {group_, name_, CF_TYPE_##type_, flags_, CF_CHECKED_OFFSET(type_, struct_, member_)}

// A whole array of rows as a table with base 0.
#define CF_TABLE(rows_) \
  ((cf_variables_t){.rows = rows_, .count = (int)(sizeof(rows_) / sizeof((rows_)[0])), .base = 0})

#endif  // CF_VARIABLE_ROW_H
