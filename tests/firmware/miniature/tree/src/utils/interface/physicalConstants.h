// Constants of physics and mathematics, unless they are there already.
#pragma once

#define SPEED_OF_LIGHT 299792458.0
#define GRAVITY_MAGNITUDE 9.81f

#ifndef M_PI
#define M_PI 3.14159265358979323846
#endif
#ifndef M_PI_F
#define M_PI_F 3.14159265358979323846f
#endif
#ifndef M_1_PI_F
#define M_1_PI_F 0.31830988618379067154f
#endif
#ifndef M_PI_2_F
#define M_PI_2_F 1.57079632679f
#endif
