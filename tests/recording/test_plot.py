import subprocess
import sys
import warnings

import imageio.v3 as iio
import numpy as np
import pytest

from crazychoir_fw.recording.colors import palette
from crazychoir_fw.recording.error_curve import ErrorCurve
from crazychoir_fw.recording.flight_log import FlightLog
from crazychoir_fw.recording.plot import plot_flight


@pytest.mark.parametrize("drones", [1, 2, 8, 9, 30])
def test_a_page_is_drawn_for_any_number_of_drones(tmp_path, drones, make_log):
    path = tmp_path / "out" / "flight.png"
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # a layout that does not fit only warns
        plot_flight(make_log(drones), path, f"Circles of {drones}")
    picture = iio.imread(path)
    assert picture.shape[:2] == (990, 1540)
    assert (picture[..., :3] < 250).any(axis=-1).mean() > 0.02  # not an empty page
    assert [p.name for p in path.parent.iterdir()] == ["flight.png"]


def test_each_of_a_few_drones_has_its_color_on_the_page(tmp_path, make_log):
    plot_flight(make_log(4), tmp_path / "flight.png", "")
    picture = iio.imread(tmp_path / "flight.png")[..., :3]
    for color in palette(4):
        rgb = [int(color[k : k + 2], 16) for k in (1, 3, 5)]
        assert (picture == rgb).all(axis=-1).sum() > 200, color


@pytest.mark.parametrize("drones", [1, 8, 9, 30, 1000])
def test_colors_are_distinct(drones):
    colors = palette(drones)
    assert len(colors) == drones
    assert len(set(colors)) >= min(drones, 200)


@pytest.mark.parametrize("present", [(), ("sim",), ("ctrltarget",), ("motor",), ("sim", "motor")])
def test_a_page_is_drawn_from_what_was_recorded(tmp_path, present, make_log):
    log = make_log(3)
    signals = {name: values for name, values in log.signals.items() if name.split(".")[0] in present}
    plot_flight(FlightLog(log.time, log.drone_ids, signals), tmp_path / "flight.png", "Partly recorded")
    assert (tmp_path / "flight.png").stat().st_size > 10000


def test_the_estimate_stands_in_for_a_truth_that_was_not_recorded(tmp_path, make_log):
    log = make_log(1)
    estimate = {f"stateEstimate.{axis}": log.signals[f"sim.{axis}"] for axis in "xyz"}
    plot_flight(FlightLog(log.time, log.drone_ids, estimate), tmp_path / "flight.png", "")
    truth = {f"sim.{axis}": log.signals[f"sim.{axis}"] for axis in "xyz"}
    plot_flight(FlightLog(log.time, log.drone_ids, truth), tmp_path / "truth.png", "")
    np.testing.assert_array_equal(iio.imread(tmp_path / "flight.png"), iio.imread(tmp_path / "truth.png"))


@pytest.mark.parametrize(("samples", "drones"), [(0, 0), (0, 2), (5, 0), (1, 1), (2, 1), (20000, 2)])
def test_odd_sizes_are_drawn(tmp_path, samples, drones, make_log):
    plot_flight(make_log(drones, samples), tmp_path / "flight.png", "Odd")
    assert (tmp_path / "flight.png").stat().st_size > 10000


def test_missing_samples_are_left_out(tmp_path, make_log):
    log = make_log(3)
    log.signals["sim.x"][50:80, 1] = np.nan
    log.signals["sim.y"][10, 0] = np.inf
    log.signals["sim.z"][:, 2] = np.nan
    plot_flight(log, tmp_path / "flight.png", "Gaps")
    assert (tmp_path / "flight.png").stat().st_size > 10000


def test_names_that_look_like_mathematics_are_drawn_as_they_are(tmp_path, make_log):
    log = make_log(2)
    log.drone_ids = ["$x^{", "_under" + "long" * 20]
    log.metadata["mission"] = "$\\frac"
    plot_flight(log, tmp_path / "flight.png", "$broken^{ title")
    assert (tmp_path / "flight.png").stat().st_size > 10000


def test_a_reference_of_zeros_is_no_reference(make_log):
    log = make_log(2, samples=10)
    for axis in "xyz":
        log.signals[f"ctrltarget.{axis}"][:4, 0] = 0.0
    log.signals["ctrltarget.x"][:, 1] = 0.0  # one coordinate alone may be zero
    reference = log.reference()
    assert np.isnan(reference[:4, 0]).all()
    assert np.isfinite(reference[4:, 0]).all()
    assert np.isfinite(reference[:, 1]).all()
    for axis in "xyz":
        log.signals[f"ctrltarget.{axis}"][:] = 0.0
    assert log.reference() is None


def test_plotting_never_touches_pyplot():
    code = "import crazychoir_fw.recording.plot, sys; sys.exit('matplotlib.pyplot' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_distance_is_shown_in_place_of_the_motors(tmp_path, make_log):
    log = make_log(2)
    least = np.linspace(2.0, 0.3, len(log.time))
    curve = ErrorCurve("least distance (m)", least, least, 0.2, is_logarithmic=False, note="the nearest two")
    plot_flight(log, tmp_path / "with.png", "", curve)
    plot_flight(log, tmp_path / "without.png", "")
    pictures = [iio.imread(tmp_path / name)[..., :3].astype(int) for name in ("with.png", "without.png")]
    lower = slice(800, 900)
    assert np.abs(pictures[0][lower, 800:] - pictures[1][lower, 800:]).max() > 100


def test_faults_and_what_stands_in_the_scene_are_drawn(make_log, tmp_path):
    log = make_log(2)
    gate = (np.array([[x, y, z] for z in (0, 1) for y in (0.0, 0.1) for x in (0.0, 0.8)]), (1.0, 0.0, 1.0))
    fault = {"time": 4.0, "kind": "fault", "drone": "cf1", "details": {"fault": "motor", "state": "begins", "motor": 2}}
    plot_flight(log, tmp_path / "without.png", "circles")
    log.metadata["windows"], log.events = [["takeoff", 0.0, 2.0]], [fault]
    plot_flight(log, tmp_path / "with.png", "circles", scenery=[gate])
    without, drawn = (iio.imread(tmp_path / f"{name}.png")[..., :3].astype(int) for name in ("without", "with"))
    red, magenta, shade = np.array([192, 57, 43]), np.array([255, 0, 255]), np.array([238, 241, 245])
    for color, near, least in ((red, 60, 150), (magenta, 60, 50), (shade, 2, 5000)):
        found = [(np.abs(picture - color).max(axis=-1) <= near).sum() for picture in (without, drawn)]
        assert found[1] > found[0] + least, (color, found)
