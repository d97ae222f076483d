/* From MuJoCo's quaternions to matrices. Internal to the plugin. */
#ifndef CF_MUJOCO_PLUGIN_ROTATION_H
#define CF_MUJOCO_PLUGIN_ROTATION_H

// Writes the rotation of a unit quaternion wxyz, row-major.
static inline void cf_rotation_of(const double quat[4], double r[9]) {
  const double w = quat[0], x = quat[1], y = quat[2], z = quat[3];
  r[0] = 1 - 2 * (y * y + z * z);
  r[1] = 2 * (x * y - w * z);
  r[2] = 2 * (x * z + w * y);
  r[3] = 2 * (x * y + w * z);
  r[4] = 1 - 2 * (x * x + z * z);
  r[5] = 2 * (y * z - w * x);
  r[6] = 2 * (x * z - w * y);
  r[7] = 2 * (y * z + w * x);
  r[8] = 1 - 2 * (x * x + y * y);
}

#endif  // CF_MUJOCO_PLUGIN_ROTATION_H
