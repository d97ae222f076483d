/* The initializers stay in this file, out of line: with constant arguments a compiler would
 * evaluate tanf itself, with another last bit than the library's. */
#include "api/filter.h"

#include <math.h>
#include <stddef.h>

#define PI_F 3.14159265358979323846f
#define BUTTERWORTH_Q 0.7071f

void lpf2pInit(lpf2pData *lpfData, float sample_freq, float cutoff_freq) {
  if (lpfData == NULL || cutoff_freq <= 0.0f) {
    return;
  }
  lpf2pSetCutoffFreq(lpfData, sample_freq, cutoff_freq);
}

void lpf2pSetCutoffFreq(lpf2pData *lpfData, float sample_freq, float cutoff_freq) {
  // O = tan(pi fc / fs),  c = 1 + 2 cos(pi/4) O + O^2
  const float fr  = sample_freq / cutoff_freq;
  const float ohm = tanf(PI_F / fr);
  const float c   = 1.0f + 2.0f * cosf(PI_F / 4.0f) * ohm + ohm * ohm;

  lpfData->b0 = ohm * ohm / c;
  lpfData->b1 = 2.0f * lpfData->b0;
  lpfData->b2 = lpfData->b0;
  lpfData->a1 = 2.0f * (ohm * ohm - 1.0f) / c;
  lpfData->a2 = (1.0f - 2.0f * cosf(PI_F / 4.0f) * ohm + ohm * ohm) / c;

  lpfData->delay_element_1 = 0.0f;
  lpfData->delay_element_2 = 0.0f;
}

float lpf2pApply(lpf2pData *lpfData, float sample) {
  const float w1 = lpfData->delay_element_1;
  const float w2 = lpfData->delay_element_2;

  // a memory that has gone bad must not stay
  float w0 = sample - w1 * lpfData->a1 - w2 * lpfData->a2;
  if (!isfinite(w0)) {
    w0 = sample;
  }

  lpfData->delay_element_2 = w1;
  lpfData->delay_element_1 = w0;
  return w0 * lpfData->b0 + w1 * lpfData->b1 + w2 * lpfData->b2;
}

float lpf2pReset(lpf2pData *lpfData, float sample) {
  const float w            = sample / (lpfData->b0 + lpfData->b1 + lpfData->b2);
  lpfData->delay_element_1 = w;
  lpfData->delay_element_2 = w;
  return lpf2pApply(lpfData, sample);
}

int16_t iirLPFilterSingle(int32_t in, int32_t attenuation, int32_t *filt) {
  const int32_t most  = 1 << IIR_SHIFT;
  const int32_t share = attenuation > most ? most : attenuation < 1 ? 1 : attenuation;

  // unsigned arithmetic, where overflow is defined; only the shift of the difference needs the sign
  const uint32_t scaled     = (uint32_t)in << IIR_SHIFT;
  const int32_t  difference = (int32_t)(scaled - (uint32_t)*filt) >> IIR_SHIFT;
  const int32_t  next       = (int32_t)((uint32_t)*filt + (uint32_t)difference * (uint32_t)share);

  *filt = next;
  return (int16_t)((next >> IIR_SHIFT) + ((next >> (IIR_SHIFT - 1)) & 1));
}

void init_second_order_low_pass(struct SecondOrderLowPass *filter, float tau, float Q,
                                float sample_time, float value) {
  const float K    = tanf(sample_time / (2.0f * tau));
  const float poly = K * K + K / Q + 1.0f;

  *filter = (struct SecondOrderLowPass){
      .a = {2.0f * (K * K - 1.0f) / poly, (K * K - K / Q + 1.0f) / poly},
      .b = {K * K / poly, 2.0f * (K * K / poly)},
      .i = {value, value},
      .o = {value, value},
  };
}

float update_second_order_low_pass(struct SecondOrderLowPass *filter, float value) {
  const float out = filter->b[0] * value + filter->b[1] * filter->i[0] +
                    filter->b[0] * filter->i[1] - filter->a[0] * filter->o[0] -
                    filter->a[1] * filter->o[1];
  filter->i[1]    = filter->i[0];
  filter->i[0]    = value;
  filter->o[1]    = filter->o[0];
  filter->o[0]    = out;
  return out;
}

float get_second_order_low_pass(const struct SecondOrderLowPass *filter) {
  return filter->o[0];
}

void init_butterworth_2_low_pass(Butterworth2LowPass *filter, float tau, float sample_time,
                                 float value) {
  init_second_order_low_pass(filter, tau, BUTTERWORTH_Q, sample_time, value);
}

float update_butterworth_2_low_pass(Butterworth2LowPass *filter, float value) {
  return update_second_order_low_pass(filter, value);
}

float get_butterworth_2_low_pass(const Butterworth2LowPass *filter) {
  return get_second_order_low_pass(filter);
}
