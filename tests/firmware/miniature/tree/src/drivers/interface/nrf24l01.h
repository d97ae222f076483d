#ifndef NRF24L01_H_
#define NRF24L01_H_
#endif  // NRF24L01_H_
