/* Averages three-axis samples between two predictions of the filter (estimators dossier 3.5). */
#ifndef AXIS3FSUBSAMPLER_H
#define AXIS3FSUBSAMPLER_H

#include <stdint.h>

#include "api/imu_types.h"

typedef struct {
  Axis3f   sum;
  uint32_t count;
  float    conversionFactor;
  Axis3f   subSample;  // the latest average, zero before the first
} Axis3fSubSampler_t;

// Empties the sampler; averages will be multiplied by the factor.
void axis3fSubSamplerInit(Axis3fSubSampler_t *subSampler, float conversionFactor);

void axis3fSubSamplerAccumulate(Axis3fSubSampler_t *subSampler, const Axis3f *sample);

// Averages what was accumulated since the last call; keeps the old average when that is nothing.
Axis3f *axis3fSubSamplerFinalize(Axis3fSubSampler_t *subSampler);

#endif  // AXIS3FSUBSAMPLER_H
