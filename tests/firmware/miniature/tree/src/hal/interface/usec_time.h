// Time since boot.
#ifndef USEC_TIME_H_
#define USEC_TIME_H_

#include <stdint.h>

void usecTimerInit(void);

// [us]
uint64_t usecTimestamp(void);

#endif /* USEC_TIME_H_ */
