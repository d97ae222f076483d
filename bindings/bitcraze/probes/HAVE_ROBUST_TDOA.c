// The robust model of distance differences takes the outlier filter.
#include "mm_tdoa_robust.h"

void probe(kalmanCoreData_t *core, tdoaMeasurement_t *tdoa, OutlierFilterTdoaState_t *filter);
void probe(kalmanCoreData_t *core, tdoaMeasurement_t *tdoa, OutlierFilterTdoaState_t *filter) {
  kalmanCoreRobustUpdateWithTdoa(core, tdoa, filter);
}
