#define _GNU_SOURCE  // RTLD_NOLOAD
#include "mujoco_plugin/mujoco_api.h"

#include <dlfcn.h>
#include <stddef.h>
#include <string.h>

// ISO C has no cast from object to function pointer; POSIX guarantees that the bytes agree.
static int find(void *library, const char *name, void *function) {
  void *symbol = dlsym(library, name);
  memcpy(function, &symbol, sizeof symbol);
  return symbol == NULL ? -1 : 0;
}

int cf_mujoco_api_find(cf_mujoco_api_t *api, const char *libmujoco_path) {
  void *library = dlopen(libmujoco_path, RTLD_NOW | RTLD_NOLOAD);
  if (library == NULL) {
    return -1;
  }
  int missing = 0;
  missing |= find(library, "mj_getPluginConfig", &api->get_config);
  missing |= find(library, "mj_id2name", &api->id2name);
  missing |= find(library, "mju_error", &api->error);
  missing |= find(library, "mjp_defaultPlugin", &api->default_plugin);
  missing |= find(library, "mjp_registerPlugin", &api->register_plugin);
  missing |= find(library, "mjp_getPlugin", &api->get_plugin);
  missing |= find(library, "mj_version", &api->version);
  missing |= find(library, "mju_rayGeom", &api->ray_geom);
  missing |= find(library, "mj_rayMesh", &api->ray_mesh);
  missing |= find(library, "mj_rayHfield", &api->ray_hfield);
  missing |= find(library, "mj_kinematics", &api->kinematics);
  missing |= find(library, "mj_comPos", &api->com_pos);
  missing |= find(library, "mj_camlight", &api->camlight);
  missing |= find(library, "mjcb_contactfilter", &api->contact_filter);
  missing |= find(library, "mjcb_time", &api->clock);
  missing |= find(library, "mjcb_passive", &api->passive);
  missing |= find(library, "mjcb_control", &api->control);
  return missing;
}
