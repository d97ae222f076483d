// Commands and registers of the radio chip.
#ifndef __NRF24L01REG_H__
#define __NRF24L01REG_H__

#define CMD_R_REG 0x00
#define CMD_W_REG 0x20
#define CMD_NOP 0xFF

#define REG_CONFIG 0x00
#define REG_RF_CH 0x05
#define REG_STATUS 0x07

#endif  // __NRF24L01REG_H__
