/* The firmware's low-pass filters, with its names (docs/reference/control-pid.md#7; the
 * second-order pair also in docs/reference/control-geometric.md#7). */
#ifndef FILTER_H
#define FILTER_H

#include <stdint.h>

#define IIR_SHIFT 8

// Second-order Butterworth low-pass in direct form II.
typedef struct {
  float a1;
  float a2;
  float b0;
  float b1;
  float b2;
  float delay_element_1;
  float delay_element_2;
} lpf2pData;

// Low-pass of second order given by time constant and quality; index 0 is the newer sample.
struct SecondOrderLowPass {
  float a[2];
  float b[2];
  float i[2];  // inputs
  float o[2];  // outputs
};
typedef struct SecondOrderLowPass Butterworth2LowPass;

// Like lpf2pSetCutoffFreq, but a null filter or a cutoff of zero or less changes nothing.
void lpf2pInit(lpf2pData *lpfData, float sample_freq, float cutoff_freq);

// Computes the coefficients for two frequencies [Hz] and clears the memory.
void lpf2pSetCutoffFreq(lpf2pData *lpfData, float sample_freq, float cutoff_freq);

// Filters one sample.
float lpf2pApply(lpf2pData *lpfData, float sample);

// Sets the filter to its steady state for the constant input `sample`; returns the filtered sample.
float lpf2pReset(lpf2pData *lpfData, float sample);

// Integer low-pass of first order with 8 fractional bits in *filt. The share of the new sample is
// attenuation / 256, with attenuation limited to [1, 256]. Returns the filtered value, rounded half
// up. A sum that overflows wraps around.
int16_t iirLPFilterSingle(int32_t in, int32_t attenuation, int32_t *filt);

// tau and sample_time in seconds; the filter starts in its steady state for the input `value`.
void  init_second_order_low_pass(struct SecondOrderLowPass *filter, float tau, float Q,
                                 float sample_time, float value);
float update_second_order_low_pass(struct SecondOrderLowPass *filter, float value);
float get_second_order_low_pass(const struct SecondOrderLowPass *filter);

// The same with the quality of a Butterworth filter, Q = 0.7071.
void  init_butterworth_2_low_pass(Butterworth2LowPass *filter, float tau, float sample_time,
                                  float value);
float update_butterworth_2_low_pass(Butterworth2LowPass *filter, float value);
float get_butterworth_2_low_pass(const Butterworth2LowPass *filter);

#endif  // FILTER_H
