/* Body rates that turn drones towards an attitude, for the geometric attitude law of
 * crazychoir_fw.control (docs/reference/crazychoir.md#4.4). */
#ifndef CF_LAWS_ATTITUDE_ERROR_H
#define CF_LAWS_ATTITUDE_ERROR_H

typedef struct {
  const double *attitudes;     // present quaternions x, y, z, w, of any length, (count, 4)
  const double *wanted;        // wanted attitudes, matrices from body to world, (count, 3, 3)
  const double *angular;       // present body rates [rad/s], (count, 3), or NULL: at rest
  const double *wanted_rates;  // at which the wanted attitude turns, in its frame, or NULL: 0
  double        k_r[3];
  double        k_w[3];
} cf_attitude_error_t;

// Writes body rates [rad/s], (count, 3): with E = (R_d' R - R' R_d) / 2 and e_R = (E32, E13, E21),
// pqr = -k_r e_R - k_w (w - R' R_d w_d) + R' R_d w_d.
void cf_attitude_rates(int count, const cf_attitude_error_t *error, double *rates);

#endif  // CF_LAWS_ATTITUDE_ERROR_H
