#include "api/axis3fSubSampler.h"

void axis3fSubSamplerInit(Axis3fSubSampler_t *subSampler, float conversionFactor) {
  *subSampler = (Axis3fSubSampler_t){.conversionFactor = conversionFactor};
}

void axis3fSubSamplerAccumulate(Axis3fSubSampler_t *subSampler, const Axis3f *sample) {
  subSampler->sum.x += sample->x;
  subSampler->sum.y += sample->y;
  subSampler->sum.z += sample->z;
  subSampler->count++;
}

Axis3f *axis3fSubSamplerFinalize(Axis3fSubSampler_t *subSampler) {
  if (subSampler->count > 0) {
    const float count       = (float)subSampler->count;
    subSampler->subSample.x = subSampler->sum.x * subSampler->conversionFactor / count;
    subSampler->subSample.y = subSampler->sum.y * subSampler->conversionFactor / count;
    subSampler->subSample.z = subSampler->sum.z * subSampler->conversionFactor / count;

    subSampler->count = 0;
    subSampler->sum   = (Axis3f){.x = 0.0f, .y = 0.0f, .z = 0.0f};
  }
  return &subSampler->subSample;
}
