"""Poses of real bodies, by UDP and by the package motioncapture."""

import json
import socket
import sys
import time
from types import SimpleNamespace

import numpy as np
import pytest

from crazychoir_fw.common.errors import MissingLibraryError, StateError
from crazychoir_fw.mocap.sources import GROUP, MotionCapture, UdpPoses, installed_source


@pytest.fixture
def listening():
    source = UdpPoses(0, clock=lambda: 5.0)
    yield source
    source.close()


def send(source, *datagrams):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sender:
        for data in datagrams:
            sender.sendto(data if isinstance(data, bytes) else json.dumps(data).encode(), ("127.0.0.1", source.port))


def test_the_newest_pose_of_each_body_counts(listening):
    send(listening, {"cf1": [1, 2, 3], "cf2": [0, 0, 1, 0, 0, 0.7071, 0.7071]}, {"cf1": [1.5, 2, 3]})
    poses = listening.latest()
    assert poses["cf1"].position.tolist() == [1.5, 2.0, 3.0]
    assert poses["cf1"].orientation.tolist() == [0.0, 0.0, 0.0, 1.0]
    assert np.linalg.norm(poses["cf2"].orientation) == pytest.approx(1.0)
    assert poses["cf1"].time == 5.0
    assert listening.latest()["cf1"] is poses["cf1"]  # nothing new


@pytest.mark.parametrize(
    "data",
    [
        b"\xff\x00",
        b"[1, 2]",
        b"[" * 50_000,
        {"cf1": [1, 2]},
        {"cf1": [1, 2, True]},
        {"cf1": "here"},
        {"cf1": [1, 2, 1e9]},
        {"cf1": [0, 0, 0, 0, 0, 0, 0]},  # occluded
        b'{"cf1": [NaN, 0, 0]}',
        b'{"cf1": [1' + b"0" * 400 + b", 0, 0]}",
    ],
)
def test_what_is_no_pose_is_left_out(listening, data):
    send(listening, data)
    assert listening.latest() == {}
    assert listening.refused == 1


def test_a_port_that_is_taken_is_said(listening):
    with pytest.raises(StateError, match=f"cannot listen on 127.0.0.1:{listening.port}"):
        UdpPoses(listening.port)


class Cameras:
    """A driver as that of the package motioncapture."""

    def __init__(self, frames):
        self.frames = iter(frames)

    def waitForNextFrame(self):
        self.rigidBodies = next(self.frames)


def test_motion_capture_by_its_package(monkeypatch):
    body = SimpleNamespace(position=np.array([1.0, 2.0, 3.0]), rotation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=1.0))
    gone = SimpleNamespace(position=np.full(3, np.nan), rotation=SimpleNamespace(x=0.0, y=0.0, z=0.0, w=0.0))
    asked = []

    def connect(system, options):
        asked.append((system, options))
        return Cameras([{"cf1": body, "cf2": gone}])

    monkeypatch.setitem(sys.modules, "motioncapture", SimpleNamespace(connect=connect))
    source = MotionCapture("vicon", "cameras.local")
    end = time.monotonic() + 10.0
    while source.failure is None and time.monotonic() < end:
        time.sleep(0.001)
    assert asked == [("vicon", {"hostname": "cameras.local"})]
    assert list(source.latest()) == ["cf1"]
    assert source.failure.startswith("motion capture: ")  # there were no more frames
    source.close()


def test_missing_package_and_unknown_system_are_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "motioncapture", None)
    with pytest.raises(StateError, match=r"pip install .crazychoir-fw\[mocap\]"):
        MotionCapture("vicon", "cameras.local")

    def connect(system, options):
        raise RuntimeError("Unknown motion capture type!")

    monkeypatch.setitem(sys.modules, "motioncapture", SimpleNamespace(connect=connect))
    with pytest.raises(StateError, match="motion capture vicon at cameras.local: Unknown"):
        MotionCapture("vicon", "cameras.local")


# ---- sources of installed packages ----


@pytest.fixture
def other_package(tmp_path, monkeypatch):
    """Return a function that installs a package which offers a source of poses, with this text."""

    def install(text):
        (tmp_path / "elsewhere.py").write_text(text)
        facts = tmp_path / "elsewhere-1.0.dist-info"
        facts.mkdir()
        (facts / "METADATA").write_text("Metadata-Version: 2.1\nName: elsewhere\nVersion: 1.0\n")
        (facts / "entry_points.txt").write_text(f"[{GROUP}]\nelsewhere = elsewhere:Poses\n")
        monkeypatch.syspath_prepend(str(tmp_path))
        monkeypatch.delitem(sys.modules, "elsewhere", raising=False)

    return install


def test_an_installed_package_offers_poses(other_package):
    other_package("class Poses:\n    def __init__(self, bodies):\n        self.bodies = bodies\n")
    assert installed_source("elsewhere")(["cf1"]).bodies == ["cf1"]


def test_ours_are_poses_of_topics():
    pytest.importorskip("rclpy")
    assert installed_source("ros").__name__ == "TopicPoses"


def test_what_a_package_lacks_is_told(other_package):
    other_package("import nowhere_to_be_found\n")
    sentence = r"poses of 'elsewhere' \(elsewhere:Poses\) cannot be loaded: No module named 'nowhere_to_be_found'"
    with pytest.raises(MissingLibraryError, match=sentence):
        installed_source("elsewhere")


def test_a_sentence_about_a_missing_library_is_kept(other_package):
    other_package(
        "from crazychoir_fw.common.errors import MissingLibraryError\n"
        "raise MissingLibraryError('needs rclpy: run pip install it')\n"
    )
    with pytest.raises(MissingLibraryError, match="^needs rclpy: run pip install it$"):
        installed_source("elsewhere")


def test_poses_that_nobody_offers_are_refused():
    with pytest.raises(MissingLibraryError, match="no installed package offers poses of 'nobody'"):
        installed_source("nobody")
