"""Trajectory files: read, written, and refused with file and line."""

import numpy as np
import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.trajectory_files import end_points, read_pieces, total_duration, write_pieces

ROW = "1.5" + ",0.25" * 32


def test_rows_become_trajectory_memory_with_the_duration_last(tmp_path):
    path = tmp_path / "t.csv"
    path.write_text("duration,x^0,…\n2," + ",".join(str(k) for k in range(32)) + ",\n\n")
    pieces = read_pieces(path)
    assert pieces.dtype == np.float32
    assert pieces.tolist() == [[*range(32), 2.0]]


def test_written_pieces_read_back_the_same(tmp_path):
    pieces = np.random.default_rng(1).uniform(0.1, 1.0, (31, 33)).astype(np.float32)
    write_pieces(tmp_path / "t.csv", pieces)
    np.testing.assert_allclose(read_pieces(tmp_path / "t.csv"), pieces, rtol=1e-6)


def test_end_points_are_values_of_the_first_and_last_polynomials():
    pieces = np.zeros((2, 33), dtype=np.float32)
    pieces[0, [0, 8, 32]] = 1.0, 2.0, 3.0  # x, y, duration
    pieces[1, [17, 24, 26, 32]] = 2.0, 0.5, 1.0, 4.0  # z = 2 t, yaw = 0.5 + t^2, duration
    first, last = end_points(pieces)
    assert first.tolist() == [1.0, 2.0, 0.0, 0.0]
    assert last.tolist() == [0.0, 0.0, 8.0, 16.5]
    assert total_duration(pieces) == 7.0


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "has 0 pieces, but a Crazyflie remembers 1 to 31"),
        (b"duration\n", "has 0 pieces"),
        ((ROW + "\n").encode() * 32, "has 32 pieces, but a Crazyflie remembers 1 to 31"),
        (b"\n1,2,3\n", "line 2 has 3 columns, but must have 33"),
        (ROW.replace("1.5", "0").encode(), "line 1: duration is '0', but must be a number in [0.01, 1000]"),
        (ROW.replace("1.5,0.25", "1.5,nan").encode(), "line 1: x^0 is 'nan', but must be a number in [-1e+06, 1e+06]"),
        (ROW.replace("1.5,0.25", "1.5,one").encode(), "line 1: x^0 is 'one'"),
        (b"\xff\xff\xff", "is not a text file"),
    ],
)
def test_bad_trajectory_file_is_refused_with_line_and_column(tmp_path, content, says):
    path = tmp_path / "bad.csv"
    path.write_bytes(content)
    with pytest.raises(MissionError) as caught:
        read_pieces(path)
    assert says in str(caught.value)
    assert "bad.csv" in str(caught.value)
