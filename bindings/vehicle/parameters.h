/* The numbers of a vehicle by name, such as rotors.time_constant_up: for callers that describe a
 * vehicle in text.
 *
 * parameters.c says where each is stored. Unit, allowed range and the values of each platform come
 * from the YAML files in crazychoir_fw/onboard/vehicles, by way of airframe_table.c. */
#ifndef CF_VEHICLE_PARAMETERS_H
#define CF_VEHICLE_PARAMETERS_H

#include "platform.h"
#include "status.h"
#include "vehicle/vehicle.h"

#define CF_PARAMETER_MAX_SIZE 4
#define CF_PARAMETER_MAX_WORDS 3
#define CF_PARAMETER_MESSAGE_BYTES 240

// What the YAML files say of a parameter.
typedef struct {
  const char *name;
  const char *unit;
  int         size;                           // numbers that belong to it
  float       lowest;                         // allowed range, in this unit
  float       highest;                        // inclusive
  const char *words[CF_PARAMETER_MAX_WORDS];  // in place of a number: the number of the word counts
  float       values[CF_PLATFORM_COUNT][CF_PARAMETER_MAX_SIZE];
} cf_parameter_facts_t;

// Number of parameters, and what is known of each; null behind the last one.
int                         cf_parameter_count(void);
const cf_parameter_facts_t *cf_parameter_facts(int i);

// Sets all parameters to the values of a platform.
void cf_parameters_of_platform(cf_vehicle_config_t *config, cf_platform_t platform);

// Sets parameters from text: `name=value name=a,b,c`, with spaces between. Words (on, off, linear
// ...) stand for choices; rotors.time_constant sets both of its kind. On CF_ERR_UNKNOWN (a name)
// and CF_ERR_VALUE `message` says what is wrong and what is allowed, and the config may have
// changed in part.
cf_status_t cf_parameters_set(cf_vehicle_config_t *config, const char *text,
                              char message[CF_PARAMETER_MESSAGE_BYTES]);

// Reads parameter i back, in its unit. Returns its size, 0 behind the last parameter.
int cf_parameter_get(const cf_vehicle_config_t *config, int i, float values[CF_PARAMETER_MAX_SIZE]);

#endif  // CF_VEHICLE_PARAMETERS_H
