#include "builtin/math/fast_math.h"

#include <math.h>
#include <stdint.h>

#include "builtin/math/sine_table.h"

#define TURNS_PER_RADIAN 0.159154943092f
#define LARGEST_TURNS 16777216.0f  // from here on a float counts whole turns only

static float sine_of_turns(float turns) {
  // negated, so that NaN goes the same way
  if (!(fabsf(turns) < LARGEST_TURNS)) {
    return turns - turns;
  }

  // the fraction of a turn, in [0, 1]
  int32_t whole = (int32_t)turns;
  if (turns < 0.0f) {
    whole--;
  }
  const float fraction = turns - (float)whole;

  // the segment, and how far into it
  float   position = (float)CF_SINE_TABLE_SEGMENTS * fraction;
  int32_t segment  = (int32_t)position;
  if (segment >= CF_SINE_TABLE_SEGMENTS) {
    segment = 0;
    position -= (float)CF_SINE_TABLE_SEGMENTS;
  }
  const float part = position - (float)segment;

  return (1.0f - part) * CF_SINE_TABLE[segment] + part * CF_SINE_TABLE[segment + 1];
}

float cf_fast_sin(float x) {
  return sine_of_turns(x * TURNS_PER_RADIAN);
}

float cf_fast_cos(float x) {
  return sine_of_turns(x * TURNS_PER_RADIAN + 0.25f);
}
