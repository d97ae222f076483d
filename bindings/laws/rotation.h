/* Rotation matrices of quaternions, for the laws. Internal to C. */
#ifndef CF_LAWS_ROTATION_H
#define CF_LAWS_ROTATION_H

// Writes the matrix from body to world, by rows, of a quaternion x, y, z, w of any length. A
// quaternion of zeros, as before the first write, is level.
static inline void cf_rotation_of(const double quaternion[4], double rotation[9]) {
  const double x = quaternion[0], y = quaternion[1], z = quaternion[2], w = quaternion[3];
  const double square = x * x + y * y + z * z + w * w;
  const double s      = square == 0.0 ? 0.0 : 2.0 / square;  // NaN stays NaN
  rotation[0]         = 1.0 - s * (y * y + z * z);
  rotation[1]         = s * (x * y - w * z);
  rotation[2]         = s * (x * z + w * y);
  rotation[3]         = s * (x * y + w * z);
  rotation[4]         = 1.0 - s * (x * x + z * z);
  rotation[5]         = s * (y * z - w * x);
  rotation[6]         = s * (x * z - w * y);
  rotation[7]         = s * (y * z + w * x);
  rotation[8]         = 1.0 - s * (x * x + y * y);
}

#endif  // CF_LAWS_ROTATION_H
