/* The few functions of MuJoCo that the plugin calls, found in the library that is already loaded.
 *
 * We do not link with MuJoCo: the wheel keeps its library in a private folder whose path differs
 * between machines. */
#ifndef CF_MUJOCO_PLUGIN_MUJOCO_API_H
#define CF_MUJOCO_PLUGIN_MUJOCO_API_H

#include <mujoco/mujoco.h>

typedef struct {
  const char *(*get_config)(const mjModel *model, int instance, const char *attribute);
  const char *(*id2name)(const mjModel *model, int type, int id);
  void (*error)(const char *format, ...);
  void (*default_plugin)(mjpPlugin *plugin);
  int (*register_plugin)(const mjpPlugin *plugin);
  const mjpPlugin *(*get_plugin)(const char *name, int *slot);
  int (*version)(void);
  mjtNum (*ray_geom)(const mjtNum pos[3], const mjtNum mat[9], const mjtNum size[3],
                     const mjtNum pnt[3], const mjtNum vec[3], int geomtype, mjtNum normal[3]);
  mjtNum (*ray_mesh)(const mjModel *model, const mjData *data, int geom, const mjtNum pnt[3],
                     const mjtNum vec[3], mjtNum normal[3]);
  mjtNum (*ray_hfield)(const mjModel *model, const mjData *data, int geom, const mjtNum pnt[3],
                       const mjtNum vec[3], mjtNum normal[3]);
  void (*kinematics)(const mjModel *model, mjData *data);
  void (*com_pos)(const mjModel *model, mjData *data);
  void (*camlight)(const mjModel *model, mjData *data);
  mjfConFilt *contact_filter;  // where the process keeps its filter
  mjfTime    *clock;           // and its clock
  mjfGeneric *passive;         // and what users add to steps
  mjfGeneric *control;
} cf_mujoco_api_t;

// Fills the table. Returns 0, or -1 when something is missing.
int cf_mujoco_api_find(cf_mujoco_api_t *api, const char *libmujoco_path);

#endif  // CF_MUJOCO_PLUGIN_MUJOCO_API_H
