/* Physical numbers of a vehicle: what the plant needs and the onboard software does not know.
 *
 * Those of the platforms are in crazychoir_fw/onboard/vehicles, with unit and source; parameters.h
 * gives them names. */
#ifndef CF_VEHICLE_AIRFRAME_H
#define CF_VEHICLE_AIRFRAME_H

#include "platform.h"
#include "status.h"
#include "vehicle/aerodynamics.h"
#include "vehicle/battery.h"
#include "vehicle/downwash.h"
#include "vehicle/ground_effect.h"
#include "vehicle/imu.h"
#include "vehicle/rotors.h"
#include "vehicle/wind.h"

typedef struct {
  float mass;                    // [kg] > 0, at take-off
  float inertia[3];              // [kg m^2] > 0, xx yy zz about the center of mass
  float products_of_inertia[3];  // [kg m^2], xy xz yz; small, may be left out
  float landed_height;           // [m] >= 0, body origin above the floor
  float trim_torque[3];          // [N m], body, in hover; in proportion to thrust

  cf_rotors_config_t        rotors;
  cf_battery_config_t       battery;
  cf_aerodynamics_config_t  aerodynamics;
  cf_ground_effect_config_t ground_effect;
  cf_downwash_config_t      downwash;
  cf_wind_config_t          wind;
  cf_imu_config_t           imu;
} cf_airframe_t;

// Returns CF_ERR_VALUE when mass, inertia, landed height or trim are outside their range.
cf_status_t cf_airframe_check(const cf_airframe_t *airframe);

#endif  // CF_VEHICLE_AIRFRAME_H
