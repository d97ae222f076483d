/* What may come back when a drone receives a packet: docs/reference/crtp-cflib.md#3.1, #7, #14. */
#ifndef CF_ONBOARD_PACKETS_PACKET_H
#define CF_ONBOARD_PACKETS_PACKET_H

#include <stdbool.h>
#include <stdint.h>

#define CF_PACKET_BYTES 30       // the largest payload
#define CF_PACKET_MAX_LOCATED 4  // vehicles that one packet can locate

// Where a vehicle is, by a positioning system.
typedef struct {
  uint8_t id;           // low byte of its radio address
  float   position[3];  // [m], world
  bool    has_attitude;
  float   quat_xyzw[4];  // body to world, of norm 1 unless the packet says otherwise
} cf_located_t;

// The answer, on the same port and channel.
typedef struct {
  int     length;  // [bytes], 0 = no answer
  uint8_t data[CF_PACKET_BYTES];
} cf_packet_reply_t;

#endif  // CF_ONBOARD_PACKETS_PACKET_H
