/* Selects the complementary estimator: the checkout's, when its two files are part of the library
 * and have the functions that the adapter calls; else the builtin provider's. */
#ifndef CF_BITCRAZE_COMPLEMENTARY_CHOICE_H
#define CF_BITCRAZE_COMPLEMENTARY_CHOICE_H

#if CF_WITH_SENSFUSION6 && CF_WITH_POSITION_ESTIMATOR_ALTITUDE && HAVE_COMPLEMENTARY
#define CF_COMPLEMENTARY_IS_THEIRS 1
#else
#define CF_COMPLEMENTARY_IS_THEIRS 0
#endif

#endif  // CF_BITCRAZE_COMPLEMENTARY_CHOICE_H
