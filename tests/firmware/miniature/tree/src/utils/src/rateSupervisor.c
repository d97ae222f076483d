#include "rateSupervisor.h"

void rateSupervisorInit(rateSupervisor_t *context, const uint32_t osTimeMs,
                        const uint32_t evaluationIntervalMs, const uint32_t minEvents,
                        const uint32_t maxEvents, const uint32_t evaluationsToSkip) {
  context->evaluationIntervalMs = evaluationIntervalMs;
  context->minEvents            = minEvents;
  context->maxEvents            = maxEvents;
  context->evaluationsToSkip    = evaluationsToSkip;
  context->count                = 0;
  context->latestCount          = 0;
  context->nextEvaluationMs     = osTimeMs + evaluationIntervalMs;
}

bool rateSupervisorValidate(rateSupervisor_t *context, const uint32_t osTimeMs) {
  bool result = true;
  context->count++;
  if (osTimeMs > context->nextEvaluationMs) {
    result = context->count >= context->minEvents && context->count <= context->maxEvents;
    context->latestCount      = context->count;
    context->count            = 0;
    context->nextEvaluationMs = osTimeMs + context->evaluationIntervalMs;
    if (context->evaluationsToSkip > 0) {
      context->evaluationsToSkip--;
      result = true;
    }
  }
  return result;
}

uint32_t rateSupervisorLatestCount(rateSupervisor_t *context) {
  return context->latestCount;
}
