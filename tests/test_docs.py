"""What README and docs promise is executed."""

import os
import re
from pathlib import Path

import mujoco
import pytest

from crazychoir_fw.campaign.campaign import check_ends, load_campaign
from crazychoir_fw.comparison.column_map import load_map
from crazychoir_fw.flight import FlightResult, fly
from crazychoir_fw.mission import load_mission, parse_mission
from crazychoir_fw.onboard import core

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", ROOT / "ARCHITECTURE.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]
# test_tutorials.py executes them
TUTORIALS = [*sorted((ROOT / "docs/tutorials").glob("*.md")), *sorted((ROOT / "docs/api").glob("*.md"))]


def blocks(page, language):
    """Return the code blocks of a page in one language."""
    return re.findall(rf"```{language}\n(.*?)```", page.read_text(), flags=re.S)


def all_blocks(language):
    return [
        pytest.param(text, id=f"{page.stem}-{number}")
        for page in PAGES
        for number, text in enumerate(blocks(page, language))
    ]


@pytest.mark.parametrize("code", all_blocks("python"))
def test_python_runs_as_printed(code, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "drone.xml").write_text(blocks(ROOT / "docs/plugin.md", "xml")[0])
    (tmp_path / "my_controller.c").write_text(blocks(ROOT / "docs/apps.md", "c")[0])
    exec(compile(code, "block", "exec"), {"__name__": "__main__"})
    printed = capsys.readouterr().out
    assert printed.strip()


CAMPAIGNS = [block for block in all_blocks("yaml") if block.id.startswith("campaign-")]


@pytest.mark.parametrize("text", CAMPAIGNS)
def test_campaigns_are_right_as_printed(text, tmp_path):
    path = tmp_path / "campaign.yaml"
    path.write_text(text.replace("extends: ", f"extends: {ROOT / 'examples'}/"))
    check_ends(load_campaign(path))


COLUMN_MAPS = [block for block in all_blocks("yaml") if block.id.startswith("compare-")]


@pytest.mark.parametrize("text", COLUMN_MAPS)
def test_column_maps_are_right_as_printed(text, tmp_path):
    path = tmp_path / "lab.yaml"
    path.write_text(text)
    assert load_map(path)


MISSIONS = [block for block in all_blocks("yaml") if block not in CAMPAIGNS + COLUMN_MAPS]


@pytest.mark.parametrize("text", MISSIONS)
def test_missions_fly_as_printed(text, tmp_path, monkeypatch, lasting_cache, miniature):
    monkeypatch.setenv("CRAZYFLIE_FIRMWARE", str(miniature))
    path = tmp_path / "mission.yaml"
    path.write_text(text)
    (tmp_path / "my_controller.c").write_text(blocks(ROOT / "docs/apps.md", "c")[0])
    assert fly(load_mission(path)).failures == []


@pytest.mark.parametrize("text", all_blocks("xml"))
def test_models_compile_as_printed(text):
    assert mujoco.MjModel.from_xml_string(text).nplugin == 1


def test_the_page_of_python_names_what_a_result_has():
    rows = (ROOT / "docs/python.md").read_text().partition("| `FlightResult` |")[2].splitlines()[2:]
    named = {name for row in rows if row.startswith("|") for name in re.findall(r"`(\w+)`", row.split("|")[1])}
    flown = fly(parse_mission({"name": "up", "drones": {"count": 1}, "flight": [{"hover": {"duration": 0.1}}]}))
    assert isinstance(flown, FlightResult)
    assert {name for name in dir(flown) if not name.startswith("_")} - {"film", "film_model", "judge"} == named


def test_table_of_attributes_is_complete():
    page = (ROOT / "docs/plugin.md").read_text()
    for name, (allowed, meaning) in core.attributes().items():
        # the providers are those of this process
        cell = "`builtin`, or the name of a library that was loaded" if name == "provider" else allowed
        cell = cell.replace("|", "&#124;")
        assert f"| `{name}` | {cell} | {meaning} |" in page


@pytest.mark.parametrize("page", [*PAGES, *TUTORIALS], ids=lambda page: page.stem)
def test_links_within_the_repository_lead_somewhere(page):
    for target in re.findall(r"\]\((?!https?:)([^)#]+)", page.read_text()):
        assert (page.parent / target).exists(), f"{page.name}: {target}"


def test_paths_named_in_the_map_exist():
    text = (ROOT / "ARCHITECTURE.md").read_text()
    named = re.findall(r"`((?:bindings|crazychoir_fw|mujoco_models|tests|firmware|docs)/[\w/.]*)`", text)
    assert len(named) > 20
    missing = [path for path in named if not os.path.lexists(ROOT / path)]
    assert missing == []


def test_every_promise_of_security_names_tests_that_exist():
    named = []
    for line in (ROOT / "docs/security.md").read_text().splitlines():
        folder = "tests/"
        for path in re.findall(r"`((?:tests|benchmarks)/[\w/.]+|test_\w+\.py)`", line.rpartition("| ")[2] or line):
            folder = path.rpartition("/")[0] + "/" if "/" in path else folder
            named.append(path if "/" in path else folder + path)
    assert len(named) > 20
    assert [path for path in named if not (ROOT / path).exists()] == []
