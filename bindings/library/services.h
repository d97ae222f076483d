/* What the vehicle's operating system gives to the firmware's modules, as far as they ask for it
 * where no task runs: the time, the console, and the end of a failed assertion.
 *
 * The definitions are weak: a checkout whose sources bring one of them gets its own. */
#ifndef CF_LIBRARY_SERVICES_H
#define CF_LIBRARY_SERVICES_H

#include <stdbool.h>
#include <stdint.h>

// Time of the drone at work, as of the present iteration of the loop.
uint64_t usecTimestamp(void);
uint32_t xTaskGetTickCount(void);  // [ms]

// Does not wait: nothing that is called from the loop may.
void vTaskDelay(uint32_t ticks);

// The console of the drone at work gets whole lines.
int  consolePutchar(int ch);
int  consolePutcharFromISR(int ch);
int  consolePuts(const char *text);
void consoleFlush(void);
int  consolePrintf(const char *format, ...) __attribute__((format(printf, 1, 2)));
int  eprintf(int (*put)(int), const char *format, ...) __attribute__((format(printf, 2, 3)));

// Ends the function that runs, and stops the drone.
_Noreturn void assertFail(char *expression, char *file, int line);

#endif  // CF_LIBRARY_SERVICES_H
