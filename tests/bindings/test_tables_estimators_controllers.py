"""Tables of parameters and log variables of estimators and controllers.

docs/reference/estimators.md#14, docs/reference/control-geometric.md#6.5, #7.6, #9.4, #10.3, #11.4.
Every group of both pages that the builtin provider has, row by row: name, type, flags, value after boot, order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pytest

from crazychoir_fw.onboard.variables import Variable, factory_values, log_table, parameter_table

BUILTIN = 0


@dataclass(frozen=True)
class Row:
    """What a page says about a variable: type as numpy calls it, c core, p persistent, r read-only."""

    name: str
    kind: str
    flags: str
    value: float | tuple[float, float]
    """After boot; two numbers are those of the platforms cf2 and cf21bl."""

    def value_on(self, platform: str) -> float:
        if isinstance(self.value, tuple):
            return self.value[("cf2", "cf21bl").index(platform)]
        return self.value


def rows(group: str, names: str, kind: str = "f4", flags: str = "", value: float = 0.0) -> list[Row]:
    """Return rows that differ in their names alone."""
    return [Row(f"{group}.{name}", kind, flags, value) for name in names.split()]


def mixed(group: str, *told: tuple) -> list[Row]:
    """Return rows of one group from (name, type, flags, value)."""
    return [Row(f"{group}.{name}", kind, flags, value) for name, kind, flags, value in told]


PARAMETERS = [
    # docs/reference/estimators.md#14.1
    *rows("kalman", "resetEstimation robustTdoa robustTwr", "u1", "c"),
    *mixed("kalman", ("pNAcc_xy", "f4", "cp", 0.5), ("pNAcc_z", "f4", "cp", 1.0)),
    *rows("kalman", "pNVel pNPos pNAtt", "f4", "cp"),
    *mixed("kalman", ("mNBaro", "f4", "cp", 2.0), ("mNGyro_rollpitch", "f4", "cp", 0.1)),
    *mixed("kalman", ("mNGyro_yaw", "f4", "cp", 0.1)),
    *rows("kalman", "initialX initialY initialZ initialYaw", "f4", "c"),
    *mixed("kalman", ("maxPos", "f4", "c", 100), ("maxVel", "f4", "c", 10)),
    *rows("kalman", "dragB_x dragB_y dragB_z cop_x cop_y cop_z", "f4", "cp"),
    # docs/reference/estimators.md#14.4
    *rows("flowdeck", "flowdeckPos_x flowdeckPos_y flowdeckPos_z", "f4", "cp"),
    *mixed("sensfusion6", ("kp", "f4", "cp", 0.8), ("ki", "f4", "cp", 0.002), ("baseZacc", "f4", "", 1.0)),
    *rows("posEstAlt", "estAlphaAsl estAlphaZr", "f4", "cp", 0.9),
    *mixed("posEstAlt", ("velFactor", "f4", "p", 1.0), ("velZAlpha", "f4", "p", 0.995)),
    *mixed("posEstAlt", ("vAccDeadband", "f4", "cp", 0.04)),
    *mixed("imu_sensors", ("BMP3XX", "u1", "r", 1)),
    *rows("imu_sensors", "imuPhi imuTheta imuPsi", "f4", "p"),
    *rows("locSrv", "enRangeStreamFP32 enLhAngleStream", "u1", "c"),
    *mixed("locSrv", ("extPosStdDev", "f4", "c", 0.01), ("extQuatStdDev", "f4", "c", 4.5e-3)),
    # docs/reference/crtp-cflib.md#14, values of cflib
    *mixed("locSrv", ("enLhMtchStm", "u1", "", 0), ("minBsLhMtchStm", "u1", "", 2), ("maxTimeLhMtchStm", "u1", "", 25)),
    # docs/reference/control-geometric.md#6.5, values of 6.2
    *mixed(
        "ctrlMel",
        *(("kp_xy", "f4", "cp", 0.4), ("kd_xy", "f4", "cp", 0.2), ("ki_xy", "f4", "cp", 0.05)),
        *(("i_range_xy", "f4", "p", 2.0), ("kp_z", "f4", "cp", 1.25), ("kd_z", "f4", "cp", 0.4)),
        *(("ki_z", "f4", "cp", 0.05), ("i_range_z", "f4", "p", 0.4), ("mass", "f4", "cp", (0.029, 0.0393))),
        *(("massThrust", "f4", "cp", 132000), ("kR_xy", "f4", "cp", 70000), ("kR_z", "f4", "cp", 60000)),
        *(("kw_xy", "f4", "cp", 20000), ("kw_z", "f4", "cp", 12000), ("ki_m_xy", "f4", "cp", 0)),
        *(("ki_m_z", "f4", "cp", 500), ("kd_omega_rp", "f4", "cp", 200), ("i_range_m_xy", "f4", "p", 1.0)),
        ("i_range_m_z", "f4", "p", 1500),
    ),
    # docs/reference/control-geometric.md#7.6
    *mixed(
        "ctrlAtt",
        *(("tau_xy", "f4", "", 0.3), ("zeta_xy", "f4", "", 0.85), ("tau_z", "f4", "", 0.3)),
        *(("zeta_z", "f4", "", 0.85), ("tau_rp", "f4", "", 0.25), ("mixing_factor", "f4", "", 1.0)),
        ("coll_fairness", "f4", "", 0.25),
    ),
    # docs/reference/control-geometric.md#9.4, values of 9.2
    *mixed("ctrlINDI", ("thrust_threshold", "f4", "", 300), ("bound_ctrl_input", "f4", "", 32000)),
    *mixed("ctrlINDI", ("g1_p", "f4", "", 0.0066146), ("g1_q", "f4", "", 0.0052125), ("g1_r", "f4", "", 0.001497)),
    *mixed("ctrlINDI", ("g2", "f4", "", 0.000043475)),
    *rows("ctrlINDI", "ref_err_p ref_err_q ref_err_r", value=5),
    *rows("ctrlINDI", "ref_rate_p ref_rate_q ref_rate_r", value=24),
    *rows("ctrlINDI", "act_dyn_p act_dyn_q act_dyn_r", value=0.03149),
    *rows("ctrlINDI", "filt_cutoff filt_cutoff_r", value=8),
    *mixed("ctrlINDI", ("outerLoopActive", "u1", "", 1)),
    # docs/reference/control-geometric.md#10.3, values of 10.1
    *rows("posCtrlIndi", "K_xi_x K_xi_y K_xi_z", value=1),
    *rows("posCtrlIndi", "K_dxi_x K_dxi_y K_dxi_z", value=5),
    *mixed("posCtrlIndi", ("pq_clamping", "f4", "", 10)),
    # docs/reference/control-geometric.md#11.4, values of 11.2
    *mixed("ctrlLee", ("KR_x", "f4", "", 0.007), ("KR_y", "f4", "", 0.007), ("KR_z", "f4", "", 0.008)),
    *rows("ctrlLee", "KI_x KI_y KI_z", value=0.03),
    *mixed("ctrlLee", ("Kw_x", "f4", "", 0.00115), ("Kw_y", "f4", "", 0.00115), ("Kw_z", "f4", "", 0.002)),
    *mixed("ctrlLee", ("J_x", "f4", "", 16.571710e-6), ("J_y", "f4", "", 16.655602e-6)),
    *mixed("ctrlLee", ("J_z", "f4", "", 29.261652e-6)),
    *rows("ctrlLee", "Kpos_Px Kpos_Py Kpos_Pz", value=7),
    *rows("ctrlLee", "Kpos_P_limit", value=100),
    *rows("ctrlLee", "Kpos_Dx Kpos_Dy Kpos_Dz", value=4),
    *rows("ctrlLee", "Kpos_D_limit", value=100),
    *rows("ctrlLee", "Kpos_Ix Kpos_Iy Kpos_Iz"),
    *rows("ctrlLee", "Kpos_I_limit", value=2),
    *mixed("ctrlLee", ("mass", "f4", "", (0.029, 0.0393))),
]

# Log variables start at zero, but for what the state after boot is: a level attitude, the first variances, gains.
LOGS = [
    # docs/reference/estimators.md#14.2
    *rows("kalman", "stateX stateY stateZ statePX statePY statePZ stateD0 stateD1 stateD2"),
    *rows("kalman", "varX varY", value=100.0**2),
    *rows("kalman", "varZ", value=1.0),
    *rows("kalman", "varPX varPY varPZ varD0 varD1 varD2", value=0.01**2),
    *rows("kalman", "q0", value=1.0),
    *rows("kalman", "q1 q2 q3 rtUpdate rtPred rtFinal"),
    # docs/reference/estimators.md#14.3
    *rows("kalman_pred", "predNX predNY measNX measNY"),
    *rows("outlierf", "lhWin", "i4", value=-16),
    *rows("tdoa", "innovation"),
    *rows("estimator", "rtApnd rtRej"),
    *rows("posEstAlt", "estimatedZ estVZ velocityZ"),
    *rows("sensfusion6", "qw", value=1.0),
    *rows("sensfusion6", "qx qy qz gravityX gravityY gravityZ"),
    *rows("sensfusion6", "accZbase", value=1.0),
    *rows("sensfusion6", "isInit isCalibrated", "u1"),
    *rows("gyro", "xRaw yRaw zRaw", "i2"),
    *rows("gyro", "xVariance yVariance zVariance"),
    *rows("ext_pos", "X Y Z"),
    *rows("locSrv", "x y z qx qy qz qw", "f4", "c"),
    *rows("locSrvZ", "tick", "u2", "c"),
    # docs/reference/control-geometric.md#6.5
    *rows("ctrlMel", "cmd_thrust cmd_roll cmd_pitch cmd_yaw r_roll r_pitch r_yaw accelz zdx zdy zdz"),
    *rows("ctrlMel", "i_err_x i_err_y i_err_z"),
    # docs/reference/control-geometric.md#9.4
    *rows("ctrlINDI", "cmd_thrust cmd_roll cmd_pitch cmd_yaw r_roll r_pitch r_yaw"),
    *rows("ctrlINDI", "u_act_dyn_p u_act_dyn_q u_act_dyn_r du_p du_q du_r"),
    *rows("ctrlINDI", "ang_accel_ref_p ang_accel_ref_q ang_accel_ref_r rate_d[0] rate_d[1] rate_d[2]"),
    *rows("ctrlINDI", "uf_p uf_q uf_r Omega_f_p Omega_f_q Omega_f_r n_p n_q n_r"),
    # docs/reference/control-geometric.md#10.3
    *rows("posCtrlIndi", "posRef_x posRef_y posRef_z velS_x velS_y velS_z velRef_x velRef_y velRef_z"),
    *rows("posCtrlIndi", "angS_roll angS_pitch angS_yaw angF_roll angF_pitch angF_yaw"),
    *rows("posCtrlIndi", "accRef_x accRef_y accRef_z accS_x accS_y accS_z accF_x accF_y accF_z"),
    *rows("posCtrlIndi", "accFT_x accFT_y accFT_z accErr_x accErr_y accErr_z"),
    *rows("posCtrlIndi", "phi_tilde theta_tilde T_tilde T_inner T_inner_f T_incremented cmd_phi cmd_theta"),
    # docs/reference/control-geometric.md#11.4
    *rows("ctrlLee", "KR_x KR_y", value=0.007),
    *rows("ctrlLee", "KR_z", value=0.008),
    *rows("ctrlLee", "Kw_x Kw_y", value=0.00115),
    *rows("ctrlLee", "Kw_z", value=0.002),
    *rows("ctrlLee", "Kpos_Px Kpos_Py Kpos_Pz", value=7),
    *rows("ctrlLee", "Kpos_Dx Kpos_Dy Kpos_Dz", value=4),
    *rows("ctrlLee", "thrustSi torquex torquey torquez rpyx rpyy rpyz rpydx rpydy rpydz"),
    *rows("ctrlLee", "error_posx error_posy error_posz error_velx error_vely error_velz"),
    *rows("ctrlLee", "omegax omegay omegaz omegarx omegary omegarz"),
]

# what the two pages say nothing about, or belongs to other tables: docs/reference/control-pid.md#17
ELSEWHERE = {"gyro.x", "gyro.y", "gyro.z"}

TABLES = {"parameters": (PARAMETERS, parameter_table), "logs": (LOGS, log_table)}
EVERY_ROW = [pytest.param(what, row, id=f"{what}-{row.name}") for what, (told, _) in TABLES.items() for row in told]


def flags(variable: Variable) -> str:
    return "c" * variable.is_core + "p" * variable.is_persistent + "r" * variable.is_read_only


@pytest.fixture(scope="module")
def booted() -> dict[tuple[str, str], dict[str, float]]:
    """Return the values after boot by table and platform."""
    return {
        (what, platform): factory_values(platform, table(BUILTIN), BUILTIN)
        for what, (_, table) in TABLES.items()
        for platform in ("cf2", "cf21bl")
    }


@pytest.mark.parametrize(("what", "row"), EVERY_ROW)
def test_variable_has_type_flags_and_factory_value_of_the_reference(booted, what, row):
    found = TABLES[what][1](BUILTIN)[row.name]
    assert (found.dtype.str[1:], flags(found)) == (row.kind, row.flags)
    for platform in ("cf2", "cf21bl"):
        value = booted[what, platform][row.name]
        assert value == pytest.approx(float(np.dtype(row.kind).type(row.value_on(platform))), rel=1e-7)


def group_of(name: str) -> str:
    return name.split(".")[0]


@pytest.mark.parametrize(
    ("what", "group"),
    [
        (what, group)
        for what, (told, _) in TABLES.items()
        for group in dict.fromkeys(group_of(row.name) for row in told)
    ],
)
def test_group_is_complete_and_in_the_order_of_the_reference(what, group):
    told, table = TABLES[what]
    found = [name for name in table(BUILTIN) if group_of(name) == group and name not in ELSEWHERE]
    assert found == [row.name for row in told if group_of(row.name) == group]
