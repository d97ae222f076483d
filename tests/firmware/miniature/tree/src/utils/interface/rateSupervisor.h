// Tells whether something happens as often as it should.
#pragma once

// clang-format off
#include <stdint.h>
#include <stdbool.h>
// clang-format on

typedef struct {
  uint32_t evaluationIntervalMs;
  uint32_t minEvents;
  uint32_t maxEvents;
  uint32_t evaluationsToSkip;
  uint32_t count;
  uint32_t latestCount;
  uint32_t nextEvaluationMs;
} rateSupervisor_t;

void     rateSupervisorInit(rateSupervisor_t *context, const uint32_t osTimeMs,
                            const uint32_t evaluationIntervalMs, const uint32_t minEvents,
                            const uint32_t maxEvents, const uint32_t evaluationsToSkip);
bool     rateSupervisorValidate(rateSupervisor_t *context, const uint32_t osTimeMs);
uint32_t rateSupervisorLatestCount(rateSupervisor_t *context);
