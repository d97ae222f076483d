/* Physical numbers of each platform: what the plant needs and the onboard software does not know.
 *
 * airframe.c gives unit and origin of each number. Thrust curve and mass come from platform.h, so
 * that plant and mixer agree. */
#ifndef CF_VEHICLE_AIRFRAME_H
#define CF_VEHICLE_AIRFRAME_H

#include "platform.h"
#include "status.h"
#include "vehicle/aerodynamics.h"
#include "vehicle/battery.h"
#include "vehicle/imu.h"
#include "vehicle/rotors.h"

typedef struct {
  float mass;                    // [kg] > 0, at take-off
  float inertia[3];              // [kg m^2] > 0, xx yy zz about the center of mass
  float products_of_inertia[3];  // [kg m^2], xy xz yz; small, may be left out
  float landed_height;           // [m] >= 0, body origin above the floor

  cf_rotors_config_t       rotors;
  cf_battery_config_t      battery;
  cf_aerodynamics_config_t aerodynamics;
  cf_imu_config_t          imu;
} cf_airframe_t;

// Writes the numbers of a platform. Returns CF_ERR_UNKNOWN for an unknown one.
cf_status_t cf_airframe(cf_airframe_t *airframe, cf_platform_t platform);

// Returns CF_ERR_VALUE when mass, inertia or landed height are outside their range.
cf_status_t cf_airframe_check(const cf_airframe_t *airframe);

#endif  // CF_VEHICLE_AIRFRAME_H
