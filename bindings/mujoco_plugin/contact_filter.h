/* Leaves out the contacts of drones that are held (sleep.h). Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_CONTACT_FILTER_H
#define CF_MUJOCO_PLUGIN_CONTACT_FILTER_H

#include "mujoco_plugin/mujoco_api.h"

// Puts the filter into MuJoCo, which has one for the whole process. A filter that was there before
// is asked first; models without drones collide as ever.
void cf_contact_filter_install(const cf_mujoco_api_t *mj);

#endif  // CF_MUJOCO_PLUGIN_CONTACT_FILTER_H
