/* Three-axis samples, with the names of the firmware's imu_types.h
 * (docs/reference/control-pid.md#2).
 */
#ifndef IMU_TYPES_H
#define IMU_TYPES_H

#include <stdint.h>

typedef struct {
  int16_t x;
  int16_t y;
  int16_t z;
} Axis3i16;

typedef struct {
  int32_t x;
  int32_t y;
  int32_t z;
} Axis3i32;

typedef struct {
  int64_t x;
  int64_t y;
  int64_t z;
} Axis3i64;

typedef union {
  struct {
    float x;
    float y;
    float z;
  };
  float axis[3];
} Axis3f;

#endif  // IMU_TYPES_H
