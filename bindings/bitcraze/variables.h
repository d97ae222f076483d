/* Tables of what is ours in a library of a checkout; the rest is captured. Internal to the adapter.
 */
#ifndef CF_BITCRAZE_VARIABLES_H
#define CF_BITCRAZE_VARIABLES_H

#include "bitcraze/checkout.h"

int cf_own_parameters(cf_variables_t *tables, int capacity);
int cf_own_logs(cf_variables_t *tables, int capacity);

#endif  // CF_BITCRAZE_VARIABLES_H
