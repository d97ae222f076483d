/* Stands in for the header of the deck drivers: what the Kalman estimator asks. */
#ifndef CF_BITCRAZE_DECK_H
#define CF_BITCRAZE_DECK_H

#include <stdbool.h>
#include <stdint.h>

bool deckGetRequiredKalmanEstimatorAttitudeReversionOff(void);

#endif  // CF_BITCRAZE_DECK_H
