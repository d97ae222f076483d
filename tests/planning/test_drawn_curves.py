"""Drawn curves: files, thinning, fitting (docs/reference/crazychoir.md#15.1)."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.common.messages import Pose
from crazychoir_fw.planning import GENTLE, Drawn, Limits, Spline, fit_drawn, read_drawn, thinned


def drawing(text, tmp_path):
    path = tmp_path / "drawing.csv"
    path.write_text(text)
    return path


def circle(samples=200, seconds=10.0):
    angles = np.linspace(0, 2 * np.pi, samples)
    points = np.stack([np.cos(angles) - 1, np.sin(angles), np.zeros(samples)], axis=1)
    return Drawn(points, angles / (2 * np.pi) * seconds)


@pytest.mark.parametrize(
    ("text", "points", "times"),
    [
        ("0,0,0\n0.1, 0.2, 0.5\n", [[0, 0, 1.3], [0.1, 0.2, 1.3]], [0, 0.5]),
        ("0,0,2,0\n1,2,3,4\n", [[0, 0, 2], [1, 2, 3]], [0, 4]),
        ("t,x,y,z\n1,0,0,2\n1,1,2,3\n", [[0, 0, 2], [1, 2, 3]], [1, 1]),
        ("# drawn\nX, Y, Time\n\n0,0,0\n1,1,1,\n", [[0, 0, 1.3], [1, 1, 1.3]], [0, 1]),
        ("0,0\n1,2\n", [[0, 0, 1.3], [1, 2, 1.3]], None),
    ],
)
def test_files_with_and_without_headings_heights_and_times(text, points, times, tmp_path):
    drawn = read_drawn(drawing(text, tmp_path), height=1.3)
    np.testing.assert_array_equal(drawn.points, points)
    assert (drawn.times is None) if times is None else drawn.times.tolist() == times


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "has 0 points, allowed: at least 2"),
        ("0,0,0\n", "has 1 points"),
        ("x,y,t\n", "has 0 points"),
        ("0,0,0\n1,nan,1\n", "line 2: y is 'nan', but must be a finite number"),
        ("0,0,0\n1,one,1\n", "line 2: y is 'one'"),
        ("0,0,1\n1,1,0.5\n", "line 2: t is 0.5, but must not be less than 1"),
        ("0,0,0\n1,1,1,1\n", "line 2 has 4 columns, but must have 3: x, y, t"),
        ("0\n1\n", "line 1 has 1 columns"),
        ("x,z,t\n0,0,0\n", "line 1: the columns are 'x, z, t', allowed: x, y, z, t"),
        ("x,y,y\n0,0,0\n", "line 1: the columns"),
    ],
)
def test_bad_files_are_refused_with_their_line(text, message, tmp_path):
    with pytest.raises(RangeError, match=message):
        read_drawn(drawing(text, tmp_path))


def test_files_that_are_none_are_refused(tmp_path):
    with pytest.raises(RangeError, match="cannot be read"):
        read_drawn(tmp_path / "missing.csv")
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(RangeError, match="not a text file"):
        read_drawn(tmp_path / "binary")


@given(st.integers(2, 60), st.integers(0, 500), st.floats(0.0, 2.0))
def test_thinning_keeps_both_ends_and_the_order(count, seed, distance):
    rng = np.random.default_rng(seed)
    drawn = Drawn(np.cumsum(rng.uniform(-0.3, 0.3, (count, 3)), axis=0), np.arange(count) * 1.0)
    few = thinned(drawn, distance)
    kept = few.times.astype(int)
    assert kept[0] == 0
    assert kept[-1] == count - 1
    assert np.all(np.diff(kept) > 0)
    np.testing.assert_array_equal(few.points, drawn.points[kept])


def test_thinning_is_that_of_the_original_and_keeps_the_last():
    drawn = Drawn(np.array([[x, 0, 0] for x in (0, 0.1, 0.15, 0.3, 0.32, 0.5, 0.65)]), np.arange(7.0))
    # a sample stays when the next one is farther than 0.2 from the last one kept; the last stays anyhow
    assert thinned(drawn, 0.2).points[:, 0].tolist() == [0, 0.15, 0.32, 0.5, 0.65]
    assert thinned(drawn, 0.0).points[:, 0].tolist() == drawn.points[:, 0].tolist()
    assert thinned(drawn, 9.0).points[:, 0].tolist() == [0, 0.65]


@pytest.mark.parametrize("method", ["spline", "minimum_snap"])
def test_a_circle_is_flown_within_gentle_limits(method):
    fit = fit_drawn(circle(seconds=2.0), distance=0.2, method=method, origin=(0, 0, 1))
    assert fit.report.holds
    assert fit.report.binding.share == pytest.approx(1.0, abs=0.01)
    assert fit.slowdown > 1.5
    assert fit.curve.duration == pytest.approx(2.0 * fit.slowdown)
    assert fit.deviation < 0.02
    np.testing.assert_allclose(fit.curve.position([0.0, fit.curve.duration]), [[0, 0, 1]] * 2, atol=1e-9)


def test_time_scale_multiplies_times():
    fit = fit_drawn(circle(), time_scale=5.0)
    assert fit.curve.duration == pytest.approx(50.0)
    assert fit.slowdown == 1.0
    assert fit_drawn(circle(), time_scale=0.1, limits=None).curve.duration == pytest.approx(1.0)


def test_samples_without_times_are_flown_as_fast_as_limits_allow():
    fit = fit_drawn(circle().points, limits=Limits(speed=0.5))
    assert fit.report.binding.share == pytest.approx(1.0, abs=0.01)
    with pytest.raises(RangeError, match="without times"):
        Drawn(circle().points).trajectory_points()


def test_free_times_are_much_shorter_than_those_of_a_hasty_hand():
    hasty, free = (
        fit_drawn(circle(seconds=2.0), distance=0.4),
        fit_drawn(circle().points, distance=0.4, method="minimum_snap"),
    )
    assert free.report.holds
    assert free.curve.duration < 0.7 * hasty.curve.duration


def test_deviation_grows_with_the_distance():
    fits = [fit_drawn(circle(), distance=d).deviation for d in (0.05, 0.3, 0.9)]
    assert fits == sorted(fits)
    assert fits[-1] > 0.01


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": [[0, 0, 0]]}, "at least 2 points"),
        ({"points": [[0, 0], [1, 1]]}, r"allowed: \(m, 3\)"),
        ({"points": [[0, 0, 0], [1, np.nan, 1]]}, "point 1 is not finite"),
        ({"times": [1.0, 0.0]}, "times must increase"),
        ({"time_scale": 0.0}, "time_scale is 0"),
        ({"distance": -1.0}, "distance is -1"),
        ({"method": "magic"}, "allowed: spline, minimum_snap"),
    ],
)
def test_bad_drawings_are_refused(change, message):
    with pytest.raises(RangeError, match=message):
        fit_drawn(**{"points": [[0, 0, 0], [1, 1, 1]], **change})


def test_a_drawing_is_sent_as_a_message():
    drawn = thinned(circle(), 0.2)
    handler = Spline(relative=True, limits=GENTLE)
    handler.set_trajectory(drawn.trajectory_points(time_scale=3.0), Pose(np.array([1.0, 2.0, 1.0])), 5.0)
    assert handler.trajectory.duration == pytest.approx(30.0)
    np.testing.assert_allclose(handler.evaluate(20.0).position, [-1.0, 2.0, 1.0], atol=0.05)


def test_bursts_of_samples_make_a_curve_without_swings():
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    points = np.stack([0.5 * np.cos(angle), 0.5 * np.sin(angle), np.ones(60)], axis=1)
    # eight moves at a time reach a page that is busy
    times = np.floor(np.arange(60) / 8.0) * 0.16 + 1e-3 * np.arange(60)

    def beside(fit):
        at = fit.curve.position(np.linspace(0.0, fit.curve.duration, 400))
        return np.abs(np.hypot(at[:, 0], at[:, 1]) - 0.5).max()

    swinging, steady = (fit_drawn(points, times, distance=0.05, steadiness=one) for one in (None, 2.0))
    assert beside(swinging) > 0.1
    assert beside(steady) < 0.02
    evenly = fit_drawn(points, np.linspace(0.0, 3.0, 60), distance=0.05, limits=None)
    again = fit_drawn(points, np.linspace(0.0, 3.0, 60), distance=0.05, limits=None, steadiness=2.0)
    assert again.curve.duration == pytest.approx(evenly.curve.duration)
    assert again.deviation == pytest.approx(evenly.deviation)
    with pytest.raises(RangeError, match=r"steadiness is 0.5, allowed: 1 or more"):
        fit_drawn(points, times, steadiness=0.5)
