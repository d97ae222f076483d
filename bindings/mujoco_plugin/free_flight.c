#include "mujoco_plugin/free_flight.h"

#include <math.h>
#include <string.h>

#include "mujoco_plugin/rotation.h"

// ---------------------------------------------------------------------- drones that can fly freely

static bool are_zero(const mjtNum *numbers, int count) {
  bool zero = true;
  for (int i = 0; i < count; i++) {
    zero = zero && numbers[i] == 0;
  }
  return zero;
}

static bool is_one_body(const drone_t *drone, const mjModel *model) {
  int bodies = 0;
  for (int body = 1; body < model->nbody; body++) {
    bodies += model->body_rootid[body] == drone->body;
  }
  return bodies == 1 && model->body_dofnum[drone->body] == 6;
}

// By its numbers; the center of mass is at the origin.
static bool is_plain(const drone_t *drone, const mjModel *model) {
  const int dof = drone->dof_address;
  return are_zero(model->body_ipos + 3 * drone->body, 3) &&
         are_zero(model->dof_armature + dof, 6) && are_zero(model->dof_damping + dof, 6) &&
         are_zero(model->dof_frictionloss + dof, 6);
}

static void tie(swarm_t *swarm, const mjModel *model, int body) {
  const int index = body >= 0 && body < model->nbody ? swarm->drone_of_body[body] : -1;
  if (index >= 0) {
    swarm->drones[index].is_free = false;
  }
}

static int body_of(const mjModel *model, int type, int object) {
  switch (type) {
    case mjOBJ_BODY:
      return object;
    case mjOBJ_SITE:
      return model->site_bodyid[object];
    case mjOBJ_GEOM:
      return model->geom_bodyid[object];
    case mjOBJ_JOINT:
      return model->jnt_bodyid[object];
    default:
      return -1;
  }
}

static void tie_by_equalities(swarm_t *swarm, const mjModel *model) {
  for (int i = 0; i < model->neq; i++) {
    const int type    = model->eq_type[i] == mjEQ_JOINT ? mjOBJ_JOINT : model->eq_objtype[i];
    const int ends[2] = {model->eq_obj1id[i], model->eq_obj2id[i]};
    for (int side = 0; side < 2; side++) {
      if (ends[side] >= 0) {
        tie(swarm, model, body_of(model, type, ends[side]));
      }
    }
  }
}

static void tie_by_tendons(swarm_t *swarm, const mjModel *model) {
  for (int i = 0; i < model->nwrap; i++) {
    const int object = model->wrap_objid[i];
    switch (model->wrap_type[i]) {
      case mjWRAP_JOINT:
        tie(swarm, model, body_of(model, mjOBJ_JOINT, object));
        break;
      case mjWRAP_SITE:
        tie(swarm, model, body_of(model, mjOBJ_SITE, object));
        break;
      case mjWRAP_SPHERE:
      case mjWRAP_CYLINDER:
        tie(swarm, model, body_of(model, mjOBJ_GEOM, object));
        break;
      default:
        break;
    }
  }
}

void cf_free_flight_new(swarm_t *swarm, const mjModel *model) {
  for (int i = 0; i < swarm->count; i++) {
    drone_t *drone = &swarm->drones[i];
    // soft bodies touch without a geom, so that a contact does not name the drone
    drone->is_free = model->nflex == 0 && is_one_body(drone, model) && is_plain(drone, model);
  }
  tie_by_equalities(swarm, model);
  tie_by_tendons(swarm, model);
}

// ---------------------------------------------------------------- drones that fly freely this step

static void note_contact(swarm_t *swarm, const mjModel *model, int geom) {
  const int index = geom >= 0 ? swarm->drone_of_body[model->geom_bodyid[geom]] : -1;
  if (index >= 0) {
    swarm->in_contact[index] = true;
    swarm->has_contacts      = true;
  }
}

static void find_contacts(swarm_t *swarm, const mjModel *model, const mjData *data) {
  if (swarm->has_contacts) {
    memset(swarm->in_contact, false, (size_t)swarm->count * sizeof *swarm->in_contact);
    swarm->has_contacts = false;
  }
  for (int i = 0; i < data->ncon; i++) {
    const mjContact *contact = &data->contact[i];
    if (contact->exclude == 0) {
      note_contact(swarm, model, contact->geom[0]);
      note_contact(swarm, model, contact->geom[1]);
    }
  }
}

// ---------------------------------------------------------------------------------------- one step

static void multiply3(const double m[9], const double v[3], double out[3]) {
  for (int i = 0; i < 3; i++) {
    out[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
  }
}

// All forces but gravity and inertia: [0-2] world, [3-5] torque in the body frame.
static void applied_to(const drone_t *drone, const mjData *data, const double quat[4],
                       double force[6]) {
  const int     dof   = drone->dof_address;
  const double *outer = data->xfrc_applied + 6 * drone->body;
  for (int i = 0; i < 6; i++) {
    force[i] =
        data->qfrc_passive[dof + i] + data->qfrc_applied[dof + i] + data->qfrc_actuator[dof + i];
  }
  if (!are_zero(outer, 6)) {
    double r[9];
    cf_rotation_of(quat, r);
    for (int i = 0; i < 3; i++) {
      force[i] += outer[i];
      force[3 + i] += r[i] * outer[3] + r[3 + i] * outer[4] + r[6 + i] * outer[5];
    }
  }
}

static void acceleration_of(const drone_t *drone, const mjModel *model, const double given[6],
                            const double rates[3], double out[6]) {
  double force[6];
  for (int i = 0; i < 6; i++) {
    force[i] = given[i] + 0.0;  // no zero is negative, wherever it comes from
  }
  const double mass       = model->body_mass[drone->body];
  const bool   is_falling = (model->opt.disableflags & mjDSBL_GRAVITY) == 0;
  for (int i = 0; i < 3; i++) {
    out[i] = force[i] / mass + (is_falling ? model->opt.gravity[i] : 0.0);
  }
  double momentum[3];
  multiply3(drone->inertia, rates, momentum);
  const double torque[3] = {force[3] - (rates[1] * momentum[2] - rates[2] * momentum[1]),
                            force[4] - (rates[2] * momentum[0] - rates[0] * momentum[2]),
                            force[5] - (rates[0] * momentum[1] - rates[1] * momentum[0])};
  multiply3(drone->inverse_inertia, torque, out + 3);
}

// Cosine of the length of a short vector and sine over length, by its square: Taylor's series, to
// the last bit of a double up to 0.05, beyond that by the library.
static void cosine_and_sinc(double square, double *cosine, double *sinc) {
  if (square < 0.0025) {
    *cosine = 1 - square / 2 * (1 - square / 12 * (1 - square / 30 * (1 - square / 56)));
    *sinc   = 1 - square / 6 * (1 - square / 20 * (1 - square / 42 * (1 - square / 72)));
  } else {
    const double angle = sqrt(square);
    *cosine            = cos(angle);
    *sinc              = sin(angle) / angle;
  }
}

// Turns a quaternion by body rates for a time [s].
static void turn(double quat[4], const double rates[3], double time) {
  const double half[3] = {0.5 * time * rates[0], 0.5 * time * rates[1], 0.5 * time * rates[2]};
  double       cosine;
  double       sinc;
  cosine_and_sinc(half[0] * half[0] + half[1] * half[1] + half[2] * half[2], &cosine, &sinc);
  const double x = sinc * half[0], y = sinc * half[1], z = sinc * half[2];
  const double a = quat[0], b = quat[1], c = quat[2], d = quat[3];
  const double w[4]   = {a * cosine - b * x - c * y - d * z, b * cosine + a * x + c * z - d * y,
                         c * cosine + a * y + d * x - b * z, d * cosine + a * z + b * y - c * x};
  const double length = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2] + w[3] * w[3]);
  for (int i = 0; i < 4; i++) {
    quat[i] = w[i] / length;
  }
}

void cf_free_flight_move(drone_t *drone, const mjModel *model, mjData *data, const double start[13],
                         const double force[6]) {
  const int    dof  = drone->dof_address;
  const double step = model->opt.timestep;
  double       acceleration[6];
  double       pose[7];
  double       twist[6];
  cf_drone_read_inertia(drone, model);
  acceleration_of(drone, model, force, start + 10, acceleration);
  for (int i = 0; i < 6; i++) {
    twist[i] = start[7 + i] + step * acceleration[i];
  }
  for (int i = 0; i < 3; i++) {
    pose[i] = start[i] + step * twist[i];
  }
  memcpy(pose + 3, start + 3, 4 * sizeof *pose);
  turn(pose + 3, twist + 3, step);

  memcpy(data->qpos + drone->qpos_address, pose, sizeof pose);
  memcpy(data->qvel + dof, twist, sizeof twist);
  memcpy(data->qacc + dof, acceleration, sizeof acceleration);
  memcpy(data->qacc_warmstart + dof, acceleration, sizeof acceleration);
  memset(data->qfrc_constraint + dof, 0, 6 * sizeof(mjtNum));
}

static bool is_ours(const swarm_t *swarm, const mjModel *model) {
  const int without_forces = mjDSBL_SPRING | mjDSBL_DAMPER;
  return swarm->has_start && model->opt.integrator == mjINT_EULER &&
         (model->opt.disableflags & without_forces) != without_forces;
}

void cf_free_flight_step(swarm_t *swarm, const mjModel *model, mjData *data) {
  if (is_ours(swarm, model)) {
    find_contacts(swarm, model, data);
    for (int i = 0; i < swarm->count; i++) {
      drone_t *drone = &swarm->drones[i];
      if (drone->is_free && !swarm->in_contact[i] && data->tree_asleep[drone->tree] < 0) {
        const double *start = swarm->work[i].coordinates;
        double        force[6];
        applied_to(drone, data, start + 3, force);
        cf_free_flight_move(drone, model, data, start, force);
      }
    }
  }
  swarm->has_start = false;
}
