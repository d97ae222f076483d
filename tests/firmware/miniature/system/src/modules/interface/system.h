#ifndef SYSTEM_H_
#define SYSTEM_H_

#include <stdbool.h>
#include <stdint.h>

void systemInit(void);
bool systemTest(void);
void systemLaunch(void);
void systemStart(void);
void systemWaitStart(void);

#endif  // SYSTEM_H_
