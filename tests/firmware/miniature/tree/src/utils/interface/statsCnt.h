// Counters that become rates in the log.
#pragma once

#include <stdint.h>

#include "log.h"

typedef struct {
  uint32_t count;
  uint32_t latestCount;
  uint32_t latestAveragingMs;
  float    latestRate;
  uint32_t intervalMs;
} statsCntRateCounter_t;

// the acquisition comes first: a row of the log points to the whole
typedef struct {
  logByFunction_t       logByFunction;
  statsCntRateCounter_t rateCounter;
} statsCntRateLogger_t;

void  statsCntRateCounterInit(statsCntRateCounter_t *counter, uint32_t averagingIntervalMs);
float statsCntRateCounterUpdate(statsCntRateCounter_t *counter, uint32_t now_ms);
float statsCntRateLogHandler(uint32_t timestamp, void *data);

// write `static` in front of it to keep the logger in its file
#define STATS_CNT_RATE_DEFINE(NAME, INTERVAL_MS)                               \
  statsCntRateLogger_t NAME = {                                                \
      .logByFunction = {.data = &NAME, .aquireFloat = statsCntRateLogHandler}, \
      .rateCounter   = {.intervalMs = INTERVAL_MS}}

#define STATS_CNT_RATE_INIT(LOGGER, INTERVAL_MS)                  \
  do {                                                            \
    (LOGGER)->logByFunction.data        = LOGGER;                 \
    (LOGGER)->logByFunction.aquireFloat = statsCntRateLogHandler; \
    statsCntRateCounterInit(&(LOGGER)->rateCounter, INTERVAL_MS); \
  } while (0)

#define STATS_CNT_RATE_EVENT(LOGGER) ((LOGGER)->rateCounter.count++)
#define STATS_CNT_RATE_MULTI_EVENT(LOGGER, COUNT) ((LOGGER)->rateCounter.count += (COUNT))

#define STATS_CNT_RATE_LOG_ADD(NAME, LOGGER) LOG_ADD_BY_FUNCTION(LOG_FLOAT, NAME, LOGGER)
