#include "arm_math.h"

#define TURNS_PER_RADIAN 0.159154943092f

float32_t arm_cos_f32(float32_t x) {
  float32_t turns = x * TURNS_PER_RADIAN + 0.25f;
  if (!(fabsf(turns) < 16777216.0f)) {
    return turns - turns;
  }

  // a table over one turn, and straight lines between its entries
  int32_t whole = (int32_t)turns;
  if (turns < 0.0f) {
    whole--;
  }
  turns           = turns - (float32_t)whole;
  float32_t at    = (float32_t)FAST_MATH_TABLE_SIZE * turns;
  int32_t   index = (int32_t)at;
  if (index >= FAST_MATH_TABLE_SIZE) {
    index = 0;
    at -= (float32_t)FAST_MATH_TABLE_SIZE;
  }
  const float32_t part = at - (float32_t)index;
  return (1.0f - part) * sinTable_f32[index] + part * sinTable_f32[index + 1];
}
