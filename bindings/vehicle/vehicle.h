/* What the firmware does not know of one Crazyflie: battery, rotors, air, sensors.
 *
 * Order of one tick of 1 ms (docs/reference/vehicle.md#13): the onboard software sets its motors,
 * `actuate` turns them, `wrench` is what the body feels during the following physics step, then the
 * sensors read the new motion. One flat struct, no pointers: copy it with memcpy. */
#ifndef CF_VEHICLE_VEHICLE_H
#define CF_VEHICLE_VEHICLE_H

#include <stdbool.h>
#include <stdint.h>

#include "api/imu_types.h"
#include "api/stabilizer_types.h"
#include "deck_facts.h"
#include "platform.h"
#include "positioning.h"
#include "status.h"
#include "variables.h"
#include "vehicle/aerodynamics.h"
#include "vehicle/airframe.h"
#include "vehicle/barometer.h"
#include "vehicle/battery.h"
#include "vehicle/ground_effect.h"
#include "vehicle/imu.h"
#include "vehicle/positioning/flow_deck.h"
#include "vehicle/positioning/lighthouse.h"
#include "vehicle/positioning/loco.h"
#include "vehicle/positioning/mocap.h"
#include "vehicle/positioning/mocap_quality.h"
#include "vehicle/random.h"
#include "vehicle/ranger.h"
#include "vehicle/rotors.h"
#include "vehicle/wind.h"

// Start from the default of a platform and change what differs.
typedef struct {
  cf_airframe_t          airframe;
  cf_positioning_t       positioning;  // the one system that is fitted
  cf_mocap_config_t      mocap;
  cf_mocap_quality_t     mocap_quality;  // whose numbers `mocap` began with
  cf_flow_deck_config_t  flow_deck;
  cf_lighthouse_config_t lighthouse;
  cf_loco_config_t       loco;
  cf_rangers_config_t    rangers;  // their noise and mishaps are those of the flow deck's range
  cf_barometer_config_t  barometer;
} cf_vehicle_config_t;

typedef struct {
  float mass;                // [kg]
  float trim_per_thrust[3];  // [m], torque (body x, y, z) per thrust

  // the air around, see cf_vehicle_feel_air
  uint32_t air_countdown;  // [ticks] to the next update
  float    surface;        // [m], world z of what is straight below
  float    downwash;       // [N] >= 0, downward, of other drones

  cf_rotors_t        rotors;
  cf_battery_t       battery;
  cf_aerodynamics_t  aerodynamics;
  cf_ground_effect_t ground_effect;
  cf_wind_t          wind;
  cf_imu_t           imu;
  cf_barometer_t     barometer;
  cf_random_t        random;  // parent generator: the others are split from it

  cf_rangers_t rangers;

  // only the fitted one is there
  cf_positioning_t positioning;
  union {
    cf_mocap_t      mocap;
    cf_flow_deck_t  flow_deck;
    cf_lighthouse_t lighthouse;
    cf_loco_t       loco;
  };
} cf_vehicle_t;

// Writes the default config. Returns CF_ERR_UNKNOWN for an unknown platform.
cf_status_t cf_vehicle_default_config(cf_vehicle_config_t *config, cf_platform_t platform);

// Fills the vehicle, rotors at rest. The sequences of noise depend on seed and id only, the errors
// of base stations and anchors on the seed alone: drones share the room. Returns
// CF_ERR_VALUE (CF_ERR_CAPACITY for the delay line of the motion capture) and leaves the vehicle
// untouched when the config holds a number outside its range.
cf_status_t cf_vehicle_init(cf_vehicle_t *vehicle, const cf_vehicle_config_t *config, uint64_t seed,
                            uint64_t id);

// Runs motors and battery for one tick with the ratios [0, 65535] that the onboard software set.
void cf_vehicle_actuate(cf_vehicle_t *vehicle, const uint16_t ratios[CF_ROTOR_COUNT]);

// Updates wind and ground effect, every 5th tick: at a position and a velocity in the world frame
// [m, m/s] and an attitude (body to world, row-major). Beside an update in every tick the gain is
// then off by at most 0.4 % in a landing at 0.3 m/s.
#define CF_AIR_TICKS 5
void cf_vehicle_feel_air(cf_vehicle_t *vehicle, const float position[3], const float rotation[9],
                         const float velocity_world[3]);

// Lets a gust begin now, in place of one that still blows: the wind rises to `peak` [m/s, world],
// each component within +-50, and is back after `duration` [s], within [0.001, 3600], as
// 1 - cosine. Returns CF_ERR_VALUE for other numbers.
cf_status_t cf_vehicle_gust(cf_vehicle_t *vehicle, const float peak[3], float duration);

// Pure: force in the world frame [N] and torque in the body frame about the center of mass [N m],
// without gravity, at an attitude (body to world, row-major), a velocity in the world frame [m/s]
// and body rates [rad/s]; with the wind and the downwash of the last update.
void cf_vehicle_wrench(const cf_vehicle_t *vehicle, const float rotation[9],
                       const float velocity_world[3], const float rates_body[3],
                       float force_world[3], float torque_body[3]);

// The sensors, once per tick each; see imu.h, barometer.h, mocap.h, flow_deck.h, lighthouse.h and
// loco.h. A positioning system that is not fitted measures nothing.
void cf_vehicle_imu(cf_vehicle_t *vehicle, const float rates_body[3], const float specific_force[3],
                    Axis3i16 *gyro_raw, Axis3i16 *acc_raw);
bool cf_vehicle_mocap(cf_vehicle_t *vehicle, const float position[3], const float quat_wxyz[4],
                      poseMeasurement_t *pose);
int  cf_vehicle_flow_deck(cf_vehicle_t *vehicle, float height, const float rotation[9],
                          const float velocity_world[3], const float rates_body[3],
                          cf_flow_reading_t *reading);
int  cf_vehicle_lighthouse(cf_vehicle_t *vehicle, const float position[3], const float rotation[9],
                           cf_sweep_t sweeps[CF_LIGHTHOUSE_STATIONS]);
bool cf_vehicle_loco(cf_vehicle_t *vehicle, const float position[3], cf_ranging_t *ranging);
bool cf_vehicle_barometer(cf_vehicle_t *vehicle, float height, float *pressure, float *temperature);

// The positioning system that is fitted, whatever it is, measures nothing while it is lost. Returns
// CF_ERR_STATE when there is none.
cf_status_t cf_vehicle_lose_positioning(cf_vehicle_t *vehicle, bool is_lost);

// Sets how late the poses of the motion capture arrive [ms]; the order of those under way is kept.
// Returns CF_ERR_STATE when none is fitted, CF_ERR_CAPACITY when too many would be under way.
cf_status_t cf_vehicle_delay_positioning(cf_vehicle_t *vehicle, uint32_t latency_ms);

// Sets the share [0, 1] of the poses of the motion capture that are lost. Returns CF_ERR_STATE when
// none is fitted, CF_ERR_VALUE for another share.
cf_status_t cf_vehicle_drop_poses(cf_vehicle_t *vehicle, float share);

// Whether a motion capture has lost the drone, so that peers receive no position of it.
bool cf_vehicle_is_out_of_sight(const cf_vehicle_t *vehicle);

// Log variables of group `sim`: what only the simulator knows. Offsets count from cf_vehicle_t.
cf_variables_t cf_vehicle_logs(void);

#endif  // CF_VEHICLE_VEHICLE_H
