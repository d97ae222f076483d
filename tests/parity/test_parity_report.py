"""The whole comparison, its page and its JSON."""

import json
import re
from html.parser import HTMLParser

import pytest

from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.parity import report, run
from crazychoir_fw.parity.cases import all_cases
from crazychoir_fw.parity.deviation import Verdict
from crazychoir_fw.parity.report import figure, html_page, tick, write_report
from crazychoir_fw.parity.run import run_parity
from crazychoir_fw.parity.side import Side

VOID = {"meta", "br", "link", "img", "input", "hr"}


class Page(HTMLParser):
    """Reads a page: what it refers to, its words, and whether every element is closed."""

    def __init__(self, text):
        super().__init__()
        self.references, self.words, self.open, self.tags = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append(tag)
        self.references += [value for name, value in attributes if name in ("src", "href", "xlink:href", "data")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open, f"</{tag}> closes nothing"
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)


@pytest.fixture(scope="module", autouse=True)
def few_cases():
    """A tenth of the cases, which have tests of their own."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(run, "all_cases", lambda inputs: all_cases(inputs)[::10])
        yield


@pytest.fixture(scope="module")
def different(short_inputs, members):
    candidate = Side(parameters={"kalman.pNAtt": 1e-4, "pid_rate.roll_kp": 252.0})
    return run_parity(Side(), candidate, 0.5, inputs=short_inputs, fleet=members("pid", "lee"))


@pytest.fixture(scope="module")
def page(different):
    return html_page(different)


def test_the_page_is_whole_and_needs_nothing_beside_itself(page):
    read = Page(page)
    assert read.open == []
    assert [reference for reference in read.references if not reference.startswith("#")] == []
    assert "@import" not in page
    assert re.findall(r"url\((?!['\"]?#)", page) == []


def test_the_page_says_who_was_compared_with_what_result(page, different):
    words = " ".join(" ".join(Page(page).words).split())
    assert "Parity: builtin against builtin on cf2" in words
    assert different.inputs["sha256"] in words
    assert "gcc" in words or "clang" in words
    assert f"{len(different.comparisons)} comparisons" in words
    assert "pid_rate.roll_kp = 252.0" in words
    assert "log.pid_rate.roll_outP" in words
    assert "because" in words


def test_the_page_follows_light_and_dark_also_in_its_pictures(page):
    assert "prefers-color-scheme: dark" in page
    pictures = re.findall(r"<svg.*?</svg>", page, flags=re.DOTALL)
    assert pictures
    for picture in pictures:
        assert "var(--reference)" in picture
        assert "var(--candidate)" in picture
        assert 'role="img"' in picture


def test_names_inside_the_pictures_are_unique(page):
    clips = re.findall(r'<clipPath id="([^"]+)"', page)
    assert len(clips) == len(set(clips))


def test_signals_are_escaped(different, monkeypatch):
    monkeypatch.setattr(report, "PLOTS", 0)
    result = different.functions[0]
    before, result.about = result.about, "<script>alert(1)</script>"
    try:
        assert "<script>alert" not in html_page(different)
    finally:
        result.about = before


def test_json_has_the_same_content(different, tmp_path, monkeypatch):
    monkeypatch.setattr(report, "PLOTS", 1)
    page, data = write_report(different, tmp_path / "new" / "folder")
    assert page.read_text().startswith("<!doctype html>")
    found = json.loads(data.read_text(), parse_constant=lambda word: pytest.fail(word))
    assert found["verdict"] == different.verdict.value == "different"
    assert found["counts"] == different.counts()
    assert found["reference"]["provider"] == "builtin"
    assert found["inputs"]["sha256"] == different.inputs["sha256"]
    assert len(found["functions"]) == len(different.functions)
    signal = found["functions"][0]["signals"][0]
    deviation = different.functions[0].deviations[0]
    assert (signal["signal"], signal["max_ulps"], signal["first_tick"]) == (
        deviation.signal,
        deviation.max_ulps,
        deviation.first_tick,
    )
    assert {row["class"] for row in found["tolerances"]["flight"]} >= {"true position"}


def test_the_verdict_of_everything_is_that_of_the_worst(different, short_inputs, members):
    assert different.verdict is Verdict.DIFFERENT
    assert different.exit_code == 1
    same = run_parity(Side(), Side(), 0.2, inputs=short_inputs, fleet=members("planar"))
    assert same.verdict is Verdict.IDENTICAL
    assert same.exit_code == 0
    words = " ".join(" ".join(Page(html_page(same)).words).split())
    assert "equal to the last bit" in words
    assert "Names, types, flags and factory values are the same" in words


def test_same_parameters_take_other_factory_values_out_of_the_way(short_inputs):
    class Tuned(Side):
        def factory_values(self):
            return {**super().factory_values(), "pid_rate.roll_kp": 251.0}

    candidate = Tuned()
    found = run_parity(Side(), candidate, 0.1, inputs=short_inputs, flies=False, has_same_parameters=True)
    assert found.aligned == {"pid_rate.roll_kp": 250.0}
    assert candidate.parameters == {"pid_rate.roll_kp": 250.0}
    assert found.flights == []
    # still told, because the vehicle has it
    assert [row.name for row in found.tables.differences] == ["pid_rate.roll_kp"]


def test_inputs_of_another_platform_are_refused(short_inputs):
    with pytest.raises(CrazychoirError, match="recorded on cf2, the providers are those of cf21bl"):
        run_parity(Side(platform="cf21bl"), Side(platform="cf21bl"), 0.1, inputs=short_inputs)


def test_figures_are_short_and_explicit():
    assert figure(1234567) == "1 234 567"
    assert figure(0.000123456) == "0.000123"
    assert figure(None) == "–"
    assert figure(float("inf")) == "unmatched"
    assert figure(float("nan")) == "not a number"
    assert tick(1514, False) == "1.514 s"
    assert tick(12, True) == "#12"
