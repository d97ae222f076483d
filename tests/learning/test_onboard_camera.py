"""Pictures as observations: what is seen is the room, from where the drone is, and of no other flight."""

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.learning import Gates, Hover, OnboardCamera, Swarm
from crazychoir_fw.learning.parallel_env import SwarmEnv
from crazychoir_fw.learning.policy import read_policy
from crazychoir_fw.learning.single_env import SingleEnv
from crazychoir_fw.learning.vector_env import FlightVectorEnv

pytestmark = pytest.mark.filterwarnings("ignore")
SMALL = OnboardCamera(width=32, height=24)


def test_gymnasium_accepts_it():
    env = gymnasium.make("crazychoir/Hover-v0", camera=SMALL, variants=1, scene="room", disable_env_checker=True)
    check_env(env.unwrapped, skip_render_check=True)
    observation, _ = env.reset(seed=1)
    assert observation["camera"].shape == (24, 32, 3) and observation["camera"].dtype == np.uint8
    assert observation["camera"].std() > 5.0, "a room is no plain color"


def test_the_picture_follows_the_drone_and_shows_no_other():
    """Five flights at one place, whose drones differ in heading alone, see what each of them alone sees."""
    changes = {"variants": 1, "scene": "room", "camera": SMALL, "start_box": (0.0, 0.0, 0.0)}
    env = FlightVectorEnv("Hover", 5, **changes)
    seen, _ = env.reset(seed=3)
    alone = SingleEnv("Hover", **changes)
    for number in range(5):
        observation, _ = alone.reset(seed=3 + number)
        assert (observation["camera"] == seen["camera"][number]).all()
    assert (seen["camera"][0] != seen["camera"][1]).any()


def test_depth_is_the_distance_along_the_view():
    """Straight down it is the height over the floor; nothing is farther than far_m."""
    still = {"start_box": (0.0, 0.0, 0.0), "start_speed": 0.0, "start_tilt_deg": 0.0, "start_rate": 0.0}
    down = OnboardCamera(width=9, height=9, kind="depth", tilt_deg=-90.0)
    observation, _ = SingleEnv(Hover(variants=1, camera=down, **still)).reset(seed=0)
    assert observation["camera"].dtype == np.float32
    assert observation["camera"][4, 4] == pytest.approx(1.2, abs=0.03)
    far = OnboardCamera(width=9, height=9, kind="depth", tilt_deg=45.0, far_m=7.0)
    observation, _ = SingleEnv(Hover(variants=1, camera=far, **still)).reset(seed=0)
    assert observation["camera"].max() == 7.0


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: OnboardCamera(kind="colour"), "kind is 'colour', allowed: image, depth"),
        (lambda: OnboardCamera(width=0), "width is 0, allowed: 1 to 1024"),
        (lambda: OnboardCamera(far_m=-1.0), "far_m is -1.0, allowed: above 0"),
        (lambda: SwarmEnv(Swarm(camera=SMALL)), "camera: allowed for tasks of a single drone"),
        (lambda: FlightVectorEnv(Gates(camera=SMALL), 2, "rgb_array"), "with a camera and 2 flights, allowed: None"),
    ],
)
def test_wrong_use_ends_in_one_sentence(make, sentence):
    with pytest.raises(RangeError, match=sentence):
        make()


def test_no_app_is_written_for_it(tmp_path):
    (tmp_path / "policy.onnx").write_bytes(b"")
    with pytest.raises(RangeError, match="a firmware app sees no pictures"):
        read_policy(tmp_path / "policy.onnx", Hover(camera=SMALL))
