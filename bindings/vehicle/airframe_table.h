/* The table that airframe_table.py makes of crazychoir_fw/onboard/vehicles. Internal to C. */
#ifndef CF_VEHICLE_AIRFRAME_TABLE_H
#define CF_VEHICLE_AIRFRAME_TABLE_H

#include "vehicle/parameters.h"

extern const cf_parameter_facts_t CF_PARAMETER_FACTS[];
extern const int                  CF_PARAMETER_FACTS_COUNT;

#endif  // CF_VEHICLE_AIRFRAME_TABLE_H
