/* Two halves of a TDoA update that newer trees of the firmware offer to replay tools, over provider
 * builtin (docs/reference/cffirmware-api.md#10.12). */
#ifndef CF_CFFI_UPSTREAM_TDOA_H
#define CF_CFFI_UPSTREAM_TDOA_H

#include "api/kalman_core.h"

// Returns measured minus predicted [m], NaN at the very place of an anchor.
float kalmanCoreTdoaInnovation(const kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa);

// kalmanCoreUpdateWithTdoa without an outlier filter. Does nothing at the very place of an anchor.
void kalmanCoreUpdateWithTdoaUnfiltered(kalmanCoreData_t *self, const tdoaMeasurement_t *tdoa);

#endif  // CF_CFFI_UPSTREAM_TDOA_H
