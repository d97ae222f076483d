#include <math.h>

#include "api/outlierFilterLighthouse.h"

#define FRAME_MS 8  // a rotor turns 120 times a second; in whole milliseconds

#define SMALLEST_WINDOW_MS (-2 * FRAME_MS)
#define LARGEST_WINDOW_MS (5 * FRAME_MS)
#define WINDOW_OF_A_GOOD_SAMPLE_MS (FRAME_MS / 2)
#define WINDOW_OF_A_BAD_SAMPLE_MS FRAME_MS
#define LARGEST_ERROR 0.05f  // [m], of a good sample

void outlierFilterLighthouseReset(OutlierFilterLhState_t *this, uint32_t nowMs) {
  *this = (OutlierFilterLhState_t){.openingTimeMs = nowMs, .openingWindowMs = SMALLEST_WINDOW_MS};
}

static int32_t next_window(int32_t window, bool is_good) {
  if (is_good) {
    const int32_t wider = window + WINDOW_OF_A_GOOD_SAMPLE_MS;
    return wider > LARGEST_WINDOW_MS ? LARGEST_WINDOW_MS : wider;
  }
  const int32_t narrower = window - WINDOW_OF_A_BAD_SAMPLE_MS;
  return narrower < SMALLEST_WINDOW_MS ? SMALLEST_WINDOW_MS : narrower;
}

bool outlierFilterLighthouseValidateSweep(OutlierFilterLhState_t *this, float distanceToBs,
                                          float angleError, uint32_t nowMs) {
  const bool is_good   = fabsf(distanceToBs * angleError) < LARGEST_ERROR;
  const bool is_closed = nowMs < this->openingTimeMs;

  // a window below zero opens in the past
  this->openingWindowMs = next_window(this->openingWindowMs, is_good);
  this->openingTimeMs   = nowMs + (uint32_t)this->openingWindowMs;
  return is_closed ? is_good : true;
}
