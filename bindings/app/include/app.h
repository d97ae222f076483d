/* The firmware's app.h for apps.
 *
 * An app's task is compiled and never run: the simulation has no tasks, only the loop, which calls
 * the app's controller and estimator. What appMain() does on the vehicle, beyond waiting, a drone
 * in simulation does not see. */
#ifndef CF_APP_APP_H
#define CF_APP_APP_H

void appMain(void);

#endif  // CF_APP_APP_H
