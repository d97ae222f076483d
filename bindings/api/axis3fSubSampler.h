/* The firmware's averager of three-axis samples, with its names (docs/reference/control-pid.md#15).
 */
#ifndef AXIS3F_SUB_SAMPLER_H
#define AXIS3F_SUB_SAMPLER_H

#include <stdint.h>

#include "api/imu_types.h"

typedef struct {
  Axis3f   sum;
  uint32_t count;  // samples in sum

  float  conversionFactor;  // applied to the mean
  Axis3f subSample;         // the last mean
} Axis3fSubSampler_t;

// Starts empty, with a mean of zero.
void axis3fSubSamplerInit(Axis3fSubSampler_t *this, float conversionFactor);

// Adds one sample.
void axis3fSubSamplerAccumulate(Axis3fSubSampler_t *this, const Axis3f *sample);

// Returns the converted mean of the samples since the last call, or the last mean if there were
// none. The result points into *this.
Axis3f *axis3fSubSamplerFinalize(Axis3fSubSampler_t *this);

#endif  // AXIS3F_SUB_SAMPLER_H
