"""Scenes that ask for more than a machine has are refused before MuJoCo builds them."""

from pathlib import Path

import pytest

from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.simulation import World
from crazychoir_fw.simulation.scene_limits import check_scene

GEOM = '<geom size="0.1"/>'


def scene(inside: str) -> str:
    return f"<mujoco><worldbody>{inside}</worldbody></mujoco>"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (scene(f'<replicate count="10000000">{GEOM}</replicate>'), "more than 200000 elements"),
        (scene('<replicate count="1000">' * 3 + GEOM + "</replicate>" * 3), "more than 200000 elements"),
        (scene(f'<replicate count="1e7">{GEOM}</replicate>'), "more than 200000 elements"),
        (scene('<flexcomp count="1000 1000 1000"/>'), "more than 200000 elements"),
        (scene('<replicate count="300000"><include file="inner.xml"/></replicate>'), "more than 200000 elements"),
        (scene(GEOM * 200_000), "more than 200000 elements"),
        (scene('<include file="scene.xml"/>'), "includes itself"),
        ('<mujoco><asset><texture width="100000" height="100000"/></asset></mujoco>', "a texture of 1e+10 cells"),
        ('<mujoco><asset><hfield nrow="100000" ncol="100000"/></asset></mujoco>', "a hfield of 1e+10 cells"),
        ('<mujoco><size memory="100G"/></mujoco>', "size memory is '100G', allowed: at most 4294967296"),
        ('<mujoco><size nconmax="2000000000"/></mujoco>', "size nconmax is '2000000000'"),
        ('<!DOCTYPE m [<!ENTITY a "b">]><mujoco/>', "entities are not allowed"),
        ("<mujoco>", "line 1: no element found"),
        ('<mujoco a="<!--"><worldbody/><b c="-->"/></mujoco>', "the value of an attribute holds '<'"),
    ],
    ids=lambda value: value[:40],
)
def test_a_scene_beyond_a_limit_is_refused_with_its_name(tmp_path, text, says):
    (tmp_path / "inner.xml").write_text(f"<mujoco>{GEOM}</mujoco>")
    (tmp_path / "scene.xml").write_text(text)
    with pytest.raises(RangeError) as caught:
        World.from_mjcf(tmp_path / "scene.xml")
    assert says in str(caught.value)
    assert "scene.xml" in str(caught.value)
    assert "\n" not in str(caught.value)


def test_attached_models_count_with_all_their_elements(tmp_path):
    (tmp_path / "part.xml").write_text(scene(GEOM * 1000))
    asset = '<asset><model name="part" file="part.xml"/></asset>'
    for count, is_refused in ((100, False), (300, True)):
        inside = f'<replicate count="{count}"><body><attach model="part"/></body></replicate>'
        (tmp_path / "scene.xml").write_text(f"<mujoco>{asset}<worldbody>{inside}</worldbody></mujoco>")
        try:
            check_scene(tmp_path / "scene.xml")
        except RangeError:
            assert is_refused
        else:
            assert not is_refused


def test_dashes_in_comments_and_our_own_scenes_are_within_the_limits(tmp_path):
    (tmp_path / "scene.xml").write_text(f"<mujoco><!-- -- a --- <b> --><worldbody>{GEOM}</worldbody></mujoco>")
    check_scene(tmp_path / "scene.xml")
    models = sorted(Path(__file__).resolve().parents[2].glob("**/*.xml"))
    assert len(models) > 5
    for path in models:
        try:
            check_scene(path)
        except CrazychoirError as error:
            assert "package.xml" in str(path), error


def test_ten_thousand_boxes_are_no_attack(tmp_path):
    (tmp_path / "scene.xml").write_text(
        scene(f'<replicate count="100"><replicate count="100">{GEOM}</replicate></replicate>')
    )
    check_scene(tmp_path / "scene.xml")
