"""C structs as rows of arrays: what NumPy writes, C reads."""

import numpy as np
import pytest

from crazychoir_fw._core import ffi
from crazychoir_fw.parity.structs import columns, dtype_of, joined_rows, pointer, zeros

STRUCTS = (
    "setpoint_t",
    "sensorData_t",
    "state_t",
    "control_t",
    "measurement_t",
    "motors_thrust_uncapped_t",
    "motors_thrust_pwm_t",
    "cf_peer_localization_t",
    "cf_base_stations_t",
    "cf_latest_samples_t",
    "struct traj_eval",
    "tdoaMeasurement_t",
)


@pytest.mark.parametrize("name", STRUCTS)
def test_rows_have_the_size_of_the_struct_and_fields_that_do_not_overlap(name):
    dtype = dtype_of(name)
    assert dtype.itemsize == ffi.sizeof(name)
    ends = 0
    for field in dtype.names:
        kind, offset = dtype.fields[field][:2]
        assert offset >= ends, field
        ends = offset + kind.itemsize


def test_what_is_written_into_a_row_is_read_in_c():
    rows = zeros("setpoint_t", 3)
    rows["position"]["y"][1] = 2.5
    rows["mode"]["yaw"][1] = 2
    rows["velocity_body"][1] = True
    setpoint = pointer(rows, "setpoint_t")[1]
    assert (setpoint.position.y, setpoint.mode.yaw, setpoint.velocity_body) == (2.5, 2, True)


def test_columns_name_every_number():
    names = set(columns(zeros("state_t", 1), "estimate"))
    assert {"estimate.position.x", "estimate.attitudeQuaternion.w", "estimate.acc.z"} <= names
    assert set(columns(zeros("motors_thrust_pwm_t", 1))) == {"list.0", "list.1", "list.2", "list.3"}


def test_joined_rows_keep_the_padding():
    rows = joined_rows([zeros("setpoint_t", 2), zeros("setpoint_t", 3)])
    assert len(rows) == 5
    assert rows.dtype.itemsize == ffi.sizeof("setpoint_t")


def test_rows_of_another_layout_are_refused():
    with pytest.raises(ValueError, match="152"):
        pointer(zeros("state_t", 2), "setpoint_t")
    with pytest.raises(ValueError, match="contiguous"):
        pointer(zeros("setpoint_t", 4)[::2], "setpoint_t")


def test_a_signal_of_an_array_member_is_a_column():
    rows = zeros("motors_thrust_pwm_t", 2)
    rows["list"] = [[1, 2, 3, 4], [5, 6, 7, 8]]
    assert np.array_equal(columns(rows, "pwm")["pwm.list.2"], [3, 7])
