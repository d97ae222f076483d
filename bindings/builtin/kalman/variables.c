#include "builtin/kalman/kalman.h"
#include "variable_row.h"

#define ROWS(table) ((int)(sizeof(table) / sizeof((table)[0])))

// rows of one float of cf_kalman_t
#define STORED(name, member) \
  CF_ROW("kalman", name, FLOAT, CF_CORE | CF_PERSISTENT, cf_kalman_t, params.member)
#define VOLATILE(name, member) CF_ROW("kalman", name, FLOAT, CF_CORE, cf_kalman_t, member)
#define FLOW_DECK(name, member) \
  CF_ROW("flowdeck", name, FLOAT, CF_CORE | CF_PERSISTENT, cf_kalman_t, flow_position.member)

// The firmware's resetEstimation belongs to the estimator task.
static const cf_variable_t PARAMETERS[] = {
    CF_ROW("kalman", "robustTdoa", UINT8, CF_CORE, cf_kalman_t, robust_tdoa),
    CF_ROW("kalman", "robustTwr", UINT8, CF_CORE, cf_kalman_t, robust_twr),
    STORED("pNAcc_xy", procNoiseAcc_xy),
    STORED("pNAcc_z", procNoiseAcc_z),
    STORED("pNVel", procNoiseVel),
    STORED("pNPos", procNoisePos),
    STORED("pNAtt", procNoiseAtt),
    STORED("mNBaro", measNoiseBaro),
    STORED("mNGyro_rollpitch", measNoiseGyro_rollpitch),
    STORED("mNGyro_yaw", measNoiseGyro_yaw),
    VOLATILE("initialX", params.initialX),
    VOLATILE("initialY", params.initialY),
    VOLATILE("initialZ", params.initialZ),
    VOLATILE("initialYaw", params.initialYaw),
    VOLATILE("maxPos", limits.max_position),
    VOLATILE("maxVel", limits.max_velocity),
    STORED("dragB_x", dragB_x),
    STORED("dragB_y", dragB_y),
    STORED("dragB_z", dragB_z),
    STORED("cop_x", cop_x),
    STORED("cop_y", cop_y),
    STORED("cop_z", cop_z),
    FLOW_DECK("flowdeckPos_x", x),
    FLOW_DECK("flowdeckPos_y", y),
    FLOW_DECK("flowdeckPos_z", z),
};

#define LOG(name, member) CF_ROW("kalman", name, FLOAT, 0, cf_kalman_t, core.member)
#define FLOW_LOG(name, member) CF_ROW("kalman_pred", name, FLOAT, 0, cf_kalman_t, flow.member)

static const cf_variable_t LOGS[] = {
    LOG("stateX", S[KC_STATE_X]),
    LOG("stateY", S[KC_STATE_Y]),
    LOG("stateZ", S[KC_STATE_Z]),
    LOG("statePX", S[KC_STATE_PX]),
    LOG("statePY", S[KC_STATE_PY]),
    LOG("statePZ", S[KC_STATE_PZ]),
    LOG("stateD0", S[KC_STATE_D0]),
    LOG("stateD1", S[KC_STATE_D1]),
    LOG("stateD2", S[KC_STATE_D2]),
    LOG("varX", P[KC_STATE_X][KC_STATE_X]),
    LOG("varY", P[KC_STATE_Y][KC_STATE_Y]),
    LOG("varZ", P[KC_STATE_Z][KC_STATE_Z]),
    LOG("varPX", P[KC_STATE_PX][KC_STATE_PX]),
    LOG("varPY", P[KC_STATE_PY][KC_STATE_PY]),
    LOG("varPZ", P[KC_STATE_PZ][KC_STATE_PZ]),
    LOG("varD0", P[KC_STATE_D0][KC_STATE_D0]),
    LOG("varD1", P[KC_STATE_D1][KC_STATE_D1]),
    LOG("varD2", P[KC_STATE_D2][KC_STATE_D2]),
    LOG("q0", q[0]),
    LOG("q1", q[1]),
    LOG("q2", q[2]),
    LOG("q3", q[3]),
    FLOW_LOG("predNX", predicted_x),
    FLOW_LOG("predNY", predicted_y),
    FLOW_LOG("measNX", measured_x),
    FLOW_LOG("measNY", measured_y),
    CF_ROW("outlierf", "lhWin", INT32, 0, cf_kalman_t, sweep_filter.openingWindowMs),
    CF_ROW("tdoa", "innovation", FLOAT, 0, cf_kalman_t, tdoa_innovation),
};

cf_variables_t cf_kalman_parameters(void) {
  return (cf_variables_t){.rows = PARAMETERS, .count = ROWS(PARAMETERS)};
}

cf_variables_t cf_kalman_logs(void) {
  return (cf_variables_t){.rows = LOGS, .count = ROWS(LOGS)};
}
