// Driver of the radio chip.
#ifndef __NRF24L01_H__
#define __NRF24L01_H__

#include <stdbool.h>

#include "nRF24L01reg.h"

#define RADIO_RATE_250K 0
#define RADIO_RATE_1M 1
#define RADIO_RATE_2M 2

void          nrfInit();
bool          nrfTest();
unsigned char nrfNop();
void          nrfSetChannel(unsigned int channel);
void          nrfSetDatarate(int datarate);
void          nrfSetEnable(bool enable);

#endif  // __NRF24L01_H__
