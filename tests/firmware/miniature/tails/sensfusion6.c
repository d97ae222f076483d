static cf_sensfusion6_t fusion = {
    .filter   = CF_SENSFUSION6_MAHONY,
    .beta     = BETA,
    .twoKp    = TWO_KP,
    .twoKi    = TWO_KI,
    .qw       = 1.0f,
    .baseZacc = 1.0f,
};

void sensfusion6Init(void) {
  cf_sensfusion6_init(&fusion);
}

bool sensfusion6Test(void) {
  return cf_sensfusion6_test(&fusion);
}

void sensfusion6UpdateQ(float gx, float gy, float gz, float ax, float ay, float az, float dt) {
  cf_sensfusion6_update_q(&fusion, gx, gy, gz, ax, ay, az, dt);
}

void sensfusion6GetQuaternion(float *qx, float *qy, float *qz, float *qw) {
  cf_sensfusion6_get_quaternion(&fusion, qx, qy, qz, qw);
}

void sensfusion6GetEulerRPY(float *roll, float *pitch, float *yaw) {
  cf_sensfusion6_get_euler_rpy(&fusion, roll, pitch, yaw);
}

float sensfusion6GetAccZWithoutGravity(const float ax, const float ay, const float az) {
  return cf_sensfusion6_get_acc_z_without_gravity(&fusion, ax, ay, az);
}

PARAM_GROUP_START(sensfusion6)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, kp, &fusion.twoKp)
PARAM_ADD_CORE(PARAM_FLOAT | PARAM_PERSISTENT, ki, &fusion.twoKi)
PARAM_ADD(PARAM_FLOAT, baseZacc, &fusion.baseZacc)
PARAM_GROUP_STOP(sensfusion6)

LOG_GROUP_START(sensfusion6)
LOG_ADD(LOG_FLOAT, qw, &fusion.qw)
LOG_ADD(LOG_FLOAT, qx, &fusion.qx)
LOG_ADD(LOG_FLOAT, qy, &fusion.qy)
LOG_ADD(LOG_FLOAT, qz, &fusion.qz)
LOG_ADD(LOG_FLOAT, gravityX, &fusion.gravX)
LOG_ADD(LOG_FLOAT, gravityY, &fusion.gravY)
LOG_ADD(LOG_FLOAT, gravityZ, &fusion.gravZ)
LOG_ADD(LOG_FLOAT, accZbase, &fusion.baseZacc)
LOG_ADD(LOG_UINT8, isInit, &fusion.isInit)
LOG_ADD(LOG_UINT8, isCalibrated, &fusion.isCalibrated)
LOG_GROUP_STOP(sensfusion6)
