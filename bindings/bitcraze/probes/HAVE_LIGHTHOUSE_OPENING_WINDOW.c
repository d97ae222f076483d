// The filter of sweep angles has a window whose width it tells.
#include "outlierFilterLighthouse.h"

int32_t probe(const OutlierFilterLhState_t *filter);
int32_t probe(const OutlierFilterLhState_t *filter) {
  return filter->openingWindowMs;
}
