#include "mujoco_plugin/thrust_plugin.h"

#include <stdlib.h>

static const cf_mujoco_api_t *mj;

// the state is the address of the velocities and the force [N]: all that compute needs
enum { DOF, QPOS, FORCE, STATE_SIZE };

static int state_size(const mjModel *model, int instance) {
  (void)model;
  (void)instance;
  return STATE_SIZE;
}

static int init(const mjModel *model, mjData *data, int instance) {
  (void)model;
  (void)data;
  (void)instance;
  return 0;
}

static void reset(const mjModel *model, mjtNum *state, void *plugin_data, int instance) {
  (void)plugin_data;
  const char *text = mj->get_config(model, instance, "thrust");
  for (int body = 0; body < model->nbody; body++) {
    if (model->body_plugin[body] == instance) {
      state[DOF]   = model->body_dofadr[body];
      state[QPOS]  = model->jnt_qposadr[model->body_jntadr[body]];
      state[FORCE] = text != NULL ? strtod(text, NULL) : 0;
    }
  }
}

static void compute(const mjModel *model, mjData *data, int instance, int capability) {
  (void)capability;
  const mjtNum *state = data->plugin_state + model->plugin_stateadr[instance];
  const mjtNum *q     = data->qpos + (int)state[QPOS] + 3;
  mjtNum       *out   = data->qfrc_passive + (int)state[DOF];
  out[0] += state[FORCE] * 2 * (q[1] * q[3] + q[0] * q[2]);
  out[1] += state[FORCE] * 2 * (q[2] * q[3] - q[0] * q[1]);
  out[2] += state[FORCE] * (1 - 2 * (q[1] * q[1] + q[2] * q[2]));
}

int cf_thrust_plugin_register(const cf_mujoco_api_t *api) {
  static const char *const attributes[] = {"thrust"};

  mj = api;
  mjpPlugin plugin;
  mj->default_plugin(&plugin);
  plugin.name            = "crazychoir.thrust";
  plugin.nattribute      = 1;
  plugin.attributes      = attributes;
  plugin.capabilityflags = mjPLUGIN_PASSIVE;
  plugin.nstate          = state_size;
  plugin.init            = init;
  plugin.reset           = reset;
  plugin.compute         = compute;
  return mj->register_plugin(&plugin);
}
