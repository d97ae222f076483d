#ifndef __DECK_H__
#define __DECK_H__

#include "deck_analog.h"
#include "deck_constants.h"
#include "deck_core.h"
#include "deck_digital.h"
#include "estimator.h"
#include "i2cdev.h"

StateEstimatorType deckGetRequiredEstimator(void);
bool               deckGetRequiredKalmanEstimatorAttitudeReversionOff(void);

#endif  // __DECK_H__
