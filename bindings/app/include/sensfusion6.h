// The firmware's sensfusion6.h for apps: the attitude filter of the complementary estimator of the
// same drone.
#ifndef CF_APP_SENSFUSION6_H
#define CF_APP_SENSFUSION6_H

#include <stdbool.h>

void  sensfusion6Init(void);
bool  sensfusion6Test(void);
void  sensfusion6UpdateQ(float gx, float gy, float gz, float ax, float ay, float az, float dt);
void  sensfusion6GetQuaternion(float *qx, float *qy, float *qz, float *qw);
void  sensfusion6GetEulerRPY(float *roll, float *pitch, float *yaw);
float sensfusion6GetAccZWithoutGravity(const float ax, const float ay, const float az);

#endif  // CF_APP_SENSFUSION6_H
