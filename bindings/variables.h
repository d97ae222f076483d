/* Parameters and log variables: rows of tables over a struct, one row, one truth.
 *
 * A row names a variable as the firmware does ("group.name"), gives its type and where it lives.
 * The offset counts from the start of the struct that the table belongs to. */
#ifndef CF_VARIABLES_H
#define CF_VARIABLES_H

#include <stdint.h>

typedef enum {
  CF_TYPE_UINT8  = 0,
  CF_TYPE_UINT16 = 1,
  CF_TYPE_UINT32 = 2,
  CF_TYPE_INT8   = 3,
  CF_TYPE_INT16  = 4,
  CF_TYPE_INT32  = 5,
  CF_TYPE_FLOAT  = 6,
} cf_type_t;

#define CF_CORE 1        // stable API of the firmware
#define CF_PERSISTENT 2  // can be stored on the drone
#define CF_READ_ONLY 4   // clients may not write it

typedef struct {
  const char *group;
  const char *name;
  cf_type_t   type;
  int         flags;   // CF_CORE | CF_PERSISTENT | CF_READ_ONLY
  uint32_t    offset;  // [bytes]
} cf_variable_t;

typedef struct {
  const cf_variable_t *rows;
  int                  count;
  uint32_t             base;  // [bytes], where the struct of these rows starts within the whole
} cf_variables_t;

#endif  // CF_VARIABLES_H
