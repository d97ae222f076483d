#include "api/axis3fSubSampler.h"

void axis3fSubSamplerInit(Axis3fSubSampler_t *this, float conversionFactor) {
  *this = (Axis3fSubSampler_t){.conversionFactor = conversionFactor};
}

void axis3fSubSamplerAccumulate(Axis3fSubSampler_t *this, const Axis3f *sample) {
  this->sum.x += sample->x;
  this->sum.y += sample->y;
  this->sum.z += sample->z;
  this->count++;
}

Axis3f *axis3fSubSamplerFinalize(Axis3fSubSampler_t *this) {
  if (this->count > 0) {
    const float count = (float)this->count;
    const float scale = this->conversionFactor;

    this->subSample.x = this->sum.x * scale / count;
    this->subSample.y = this->sum.y * scale / count;
    this->subSample.z = this->sum.z * scale / count;

    this->count = 0;
    this->sum   = (Axis3f){.axis = {0.0f, 0.0f, 0.0f}};
  }
  return &this->subSample;
}
