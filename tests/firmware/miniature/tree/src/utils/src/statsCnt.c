#include "statsCnt.h"

void statsCntRateCounterInit(statsCntRateCounter_t *counter, uint32_t averagingIntervalMs) {
  counter->count             = 0;
  counter->latestCount       = 0;
  counter->latestAveragingMs = 0;
  counter->latestRate        = 0.0f;
  counter->intervalMs        = averagingIntervalMs;
}

float statsCntRateCounterUpdate(statsCntRateCounter_t *counter, uint32_t now_ms) {
  const uint32_t dt = now_ms - counter->latestAveragingMs;
  if (dt > counter->intervalMs) {
    const uint32_t events      = counter->count - counter->latestCount;
    counter->latestRate        = events * 1000.0f / dt;
    counter->latestCount       = counter->count;
    counter->latestAveragingMs = now_ms;
  }
  return counter->latestRate;
}

float statsCntRateLogHandler(uint32_t timestamp, void *data) {
  statsCntRateLogger_t *logger = (statsCntRateLogger_t *)data;
  return statsCntRateCounterUpdate(&logger->rateCounter, timestamp);
}
