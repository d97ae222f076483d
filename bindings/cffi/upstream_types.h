/* Small types of upstream's stabilizer_types.h that a drone does not use, for scripts that name
 * them as upstream does (crazychoir_fw.cffirmware). */
#ifndef CF_CFFI_UPSTREAM_TYPES_H
#define CF_CFFI_UPSTREAM_TYPES_H

#include <stdbool.h>
#include <stdint.h>

#include "api/stabilizer_types.h"

typedef struct {
  uint32_t timestamp;
  float    distance;  // [m]
} zDistance_t;

typedef struct {
  uint32_t timestamp;
  point_t  position;  // [m]
} estimate_t;

typedef struct {
  float z;  // [m]
  bool  isUpdate;
} setpointZ_t;

#endif  // CF_CFFI_UPSTREAM_TYPES_H
