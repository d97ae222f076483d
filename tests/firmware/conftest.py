"""What tests of builds share: an empty cache, a tree that tells whether it was written to, libraries of releases."""

import fcntl
import hashlib
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from miniature import lay_out
from side_by_side import Drone

from crazychoir_fw.firmware.build import build_provider
from crazychoir_fw.firmware.levels import ALGORITHMS
from crazychoir_fw.onboard.core import load_library

HERE = Path(__file__).parent


@pytest.fixture
def cache_folder(tmp_path, monkeypatch):
    """An empty cache for one test."""
    folder = tmp_path / "the cache"
    monkeypatch.setenv("CRAZYCHOIR_CACHE", str(folder))
    return folder


@pytest.fixture
def photograph():
    """Return everything about a tree: names, modes, times and contents."""

    def take(root):
        return {
            str(path.relative_to(root)): (
                path.lstat().st_mode,
                path.lstat().st_mtime_ns,
                hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else "",
            )
            for path in sorted(root.rglob("*"))
        }

    return take


@pytest.fixture(scope="session")
def releases_folder(tmp_path_factory):
    return tmp_path_factory.mktemp("firmware")


@pytest.fixture(scope="session")
def parts_digest():
    """A digest of all that the miniature is made of."""
    parts = [path for path in sorted((HERE / "miniature").rglob("*")) if path.is_file() and path.suffix != ".pyc"]
    parts += sorted((HERE.parents[1] / "bindings").rglob("*.[ch]"))
    return hashlib.sha256(b"".join(path.read_bytes() for path in parts)).hexdigest()[:12]


@pytest.fixture(scope="session")
def checkout_of(lasting_folder, parts_digest):
    """Return the checkout of a release. Not to be written to.

    It always lies in the same place, so that only what has changed since the last session is compiled.
    """

    def find(release):
        root = lasting_folder / release
        mark = root / "laid out"
        with (lasting_folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if not mark.exists() or mark.read_text() != parts_digest:
                shutil.rmtree(root, ignore_errors=True)
                form = {"2024.10": "2023", "2025.02": "2025"}.get(release, "2026")
                lay_out(root, release=release, setup_py=form)
                mark.write_text(parts_digest)
        return root

    return find


@pytest.fixture(scope="session")
def level_library(checkout_of, lasting_cache):
    """Return the library of a release at a level; what did not change since the last session is not compiled."""

    def build(release, level, platform="cf2"):
        return build_provider(checkout_of(release), platform, level=level)

    return build


@pytest.fixture(scope="session")
def level_word(level_library):
    """Return the word of a provider that flies a release at a level, loaded if need be."""
    words = {}

    def load(release, level, platform="cf2"):
        key = (release, level, platform)
        if key not in words:
            words[key] = f"miniature-{release}-{level}"
            load_library(replace(level_library(*key), name=words[key]))
        return words[key]

    return load


@pytest.fixture(scope="session")
def own_checkout(lasting_folder, worker_id):
    """A checkout of this worker of pytest."""
    root = lasting_folder / f"edited_by_{worker_id}"
    shutil.rmtree(root, ignore_errors=True)
    return lay_out(root, release="2026.08", setup_py="2026")


@pytest.fixture
def edited(own_checkout, lasting_cache):
    """A checkout of the newest release that a test may write to; afterwards it is as it was."""
    before = {path: path.read_bytes() for path in own_checkout.rglob("*") if path.is_file()}
    yield own_checkout
    for path in own_checkout.rglob("*"):
        if path.is_file() and path not in before:
            path.unlink()
    for path, content in before.items():
        if not path.is_file() or path.read_bytes() != content:
            path.write_bytes(content)


@pytest.fixture(scope="session")
def newest(level_library):
    return level_library("2026.08", ALGORITHMS)


@pytest.fixture(scope="session")
def older(level_library):
    return level_library("2025.02", ALGORITHMS)


@pytest.fixture(scope="session")
def oldest(level_library):
    return level_library("2024.10", ALGORITHMS)


APP = """
#include "controller.h"
#include "estimator/estimator.h"
#include "stabilizer_types.h"

static int count;

void controllerOutOfTreeInit(void) { count = 0; }
bool controllerOutOfTreeTest(void) { return true; }
void controllerOutOfTree(control_t *control, const setpoint_t *setpoint, const sensorData_t *sensors,
                         const state_t *state, const stabilizerStep_t stabilizerStep) {
  count++;
  control->controlMode = controlModeForceTorque;
  control->thrustSi = setpoint->jerk.z + state->position.z + sensors->gyro.x;
  control->torqueX = count;
}

void estimatorOutOfTreeInit(void) {}
bool estimatorOutOfTreeTest(void) { return true; }
void estimatorOutOfTree(state_t *state, const stabilizerStep_t stabilizerStep) {
  measurement_t m;
  state->position.x = 0;
  while (estimatorDequeue(&m)) {
    state->position.x += 1;
    if (m.type == MeasurementTypeSweepAngle) {
      state->position.y = m.data.sweepAngle.calib->tilt;
    } else if (m.type == MeasurementTypeTOF) {
      state->position.z = m.data.tof.coneHalfAngle;
    }
  }
}
"""

BROKEN = '#error "needs a driver"\n'


@pytest.fixture(scope="session")
def poor(releases_folder, lasting_cache):
    """For the other platform, with an app; the pose model and the complementary estimator do not compile, and there
    are neither INDI nor the supervisor of the filter."""
    checkout = lay_out(releases_folder / "poor", release="2026.08", setup_py="2025")
    modules = checkout / "src/modules/src"
    (modules / "kalman_core/mm_pose.c").write_text(BROKEN)
    (modules / "estimator/position_estimator_altitude.c").write_text(BROKEN)
    (modules / "kalman_supervisor.c").unlink()
    (modules / "controller/controller_indi.c").unlink()
    (releases_folder / "mine.c").write_text(APP)
    return build_provider(checkout, "cf21bl", [releases_folder / "mine.c"])


@pytest.fixture
def pair(newest):
    """A builtin drone and one of the newest release."""
    return Drone(0), Drone(load_library(newest))


@pytest.fixture
def rng():
    return np.random.default_rng(4)
