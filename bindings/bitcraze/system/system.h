/* The checkout's own modules as one: boot, tick and requests (cf_system_t of provider.h), and what
 * stands around them in place of drivers, links and decks. Internal to the adapter.
 *
 * Everything is called with the image of the drone at work in place, so that `state` says nothing.
 * The modules run as the tasks that they are, over rtos/. */
#ifndef CF_BITCRAZE_SYSTEM_H
#define CF_BITCRAZE_SYSTEM_H

#include "bitcraze/adapter.h"

// The functions of the table.
const cf_system_t *cf_system(void);

// ------------------------------------------------------------------------------------- sensors.c

// What the driver of the sensors would have; a part of the image.
typedef struct {
  sensorData_t data;
  bool         are_calibrated;
} cf_system_sensors_t;
extern cf_system_sensors_t cf_system_sensors;

// -------------------------------------------------------------------------------------- motors.c

// What the motors hold, after what the driver of a release does by itself; battery [V].
void cf_system_motors(float battery_voltage, api_motors_thrust_pwm_t *motors);

// -------------------------------------------------------------------------------------- loop.c

// What the loop came to, as the controller saw it.
typedef struct {
  stabilizerStep_t step;
  state_t          estimate;
  setpoint_t       setpoint;
  control_t        control;
} cf_system_seen_t;
extern cf_system_seen_t cf_system_seen;

// What the supervisor's state machine came to, in our numbers.
extern int cf_system_supervisor_state;

// What is asked of the loop where it is ours, as are its parameters.
typedef struct {
  int  controller;
  int  estimator;
  bool is_held;
} cf_system_wanted_t;
extern cf_system_wanted_t cf_system_wanted;

// ------------------------------------------------------------------------------------- sweeps.c

// Puts a measurement into the queue of the estimator.
void cf_system_enqueue(const api_measurement_t *from);

// --------------------------------------------------------------------------------------- link.c

void cf_link_boot(void);
// See cf_system_t.packet.
int  cf_link_packet(uint8_t port, uint8_t channel, const uint8_t *data, int length,
                    uint8_t reply[CF_SYSTEM_PACKET_BYTES]);
bool cf_link_read_trajectory(uint32_t offset, uint32_t length, uint8_t *data);
bool cf_link_write_trajectory(uint32_t offset, uint32_t length, const uint8_t *data);
void cf_link_stop_for_good(void);  // emergency stop
void cf_link_feed_watchdog(uint32_t now_ms);

#endif  // CF_BITCRAZE_SYSTEM_H
