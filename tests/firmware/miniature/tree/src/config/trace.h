// Traces of the operating system. The words go to an address that only the vehicle has.
#ifndef __TRACE_H__
#define __TRACE_H__

#include "autoconf.h"

#define ITM_SEND(CH, DATA) (((volatile unsigned int *)0xE0000000)[CH] = DATA)
#define traceTASK_SWITCHED_OUT() ITM_SEND(1, 0)

#endif  // __TRACE_H__
