"""What may stand in a campaign file, and the sentences about what may not."""

import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from typer.testing import CliRunner

from crazychoir_fw.campaign import identity as known_by
from crazychoir_fw.campaign.campaign import Variant, check_ends, load_campaign
from crazychoir_fw.campaign.design import correlate, shares
from crazychoir_fw.campaign.identity import identity_of, named_files
from crazychoir_fw.campaign.starting import written
from crazychoir_fw.cli import app
from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.mission.distributions import read_distribution
from crazychoir_fw.mission.loader import load_mission


@pytest.mark.parametrize(
    ("given_", "quarter", "half"),
    [
        ({"normal": {"mean": 2.0, "std": 0.5}}, 2.0 - 0.6744897501960817 * 0.5, 2.0),
        ({"uniform": [1, 3]}, 1.5, 2.0),
        ({"log_uniform": [0.1, 10]}, 10**-0.5, 1.0),
        ({"triangular": [0, 1, 2]}, math.sqrt(0.5), 1.0),
        ({"choice": ["a", "b"]}, "a", "b"),
        ({"uniform": [0, 1], "low": 0.5}, 0.625, 0.75),
    ],
)
def test_distributions(given_, quarter, half):
    found = read_distribution("vary.x", given_)
    assert found.at(0.25) == pytest.approx(quarter)
    assert found.at(0.5) == pytest.approx(half)


@given(
    st.sampled_from([({"normal": {"mean": 1.0, "std": 2.0}}, stats.norm(1.0, 2.0)),
                     ({"uniform": [-1, 3]}, stats.uniform(-1, 4)),
                     ({"log_uniform": [0.01, 10]}, stats.loguniform(0.01, 10)),
                     ({"triangular": [-1, 0, 3]}, stats.triang(0.25, -1, 4))]),
    st.floats(0.001, 0.999),
)  # fmt: skip
def test_quantiles_are_those_of_scipy(case, share):
    written, scipy = case
    found = read_distribution("vary.x", written)
    assert found.at(share) == pytest.approx(scipy.ppf(share), rel=1e-9, abs=1e-12)
    cut = read_distribution("vary.x", {**written, "low": 0.5, "high": 2.0})
    low, high = scipy.cdf([0.5, 2.0])
    assert cut.at(share) == pytest.approx(scipy.ppf(low + share * (high - low)), rel=1e-7)


@given(st.floats(0.0, 1.0))
def test_cut_off_distributions_stay_within(share):
    found = read_distribution("vary.x", {"normal": {"mean": 0.0, "std": 1.0}, "low": -0.3, "high": 2.0})
    assert -0.3 <= found.at(share) <= 2.0


@pytest.mark.parametrize(
    ("keys", "sentence"),
    [
        ({"vary": {"defaults.mass": 3}}, "vary.defaults.mass is 3, but must be a distribution such as"),
        ({"vary": {"defaults.mass": {"norml": {}}}}, "did you mean 'normal'?"),
        ({"vary": {"defaults.mass": {"uniform": [2, 1]}}}, "must be a list of 2 numbers that increase"),
        ({"vary": {"defaults.mass": {"log_uniform": [-1, 1]}}}, "above 0"),
        ({"vary": {"defaults.mass": {"normal": {"mean": 1, "std": 0}}}}, "a std above 0"),
        ({"vary": {"defaults.mass": {"uniform": [0, 1], "low": 2}}}, "must leave some of it"),
        ({"vary": {"defaults.mass": {"choice": []}}}, "at least one entry"),
        ({"flights": 0}, "flights is 0, but must be a whole number in [1, 1000000]"),
        ({"design": "lhs"}, "but must be one of monte_carlo"),
        ({"flihgts": 3}, "has no key 'flihgts' (did you mean 'flights'?)"),
        ({"require": {"success": 1.2}}, "require.success is 1.2, but must be a number in"),
        ({"vary": {}, "correlated": [{"keys": ["a", "b"], "correlation": 0.5}]}, "must name keys of vary"),
    ],
)
def test_mistakes_are_sentences(campaign, keys, sentence):
    with pytest.raises(MissionError) as error:
        campaign(**keys)
    assert sentence in str(error.value)
    assert "\n" not in str(error.value)


def test_values_that_a_mission_refuses_are_found_before_anything_flies(campaign):
    whole = campaign(vary={"defaults.mass": {"uniform": [0.02, 0.9]}}, flights=3)
    with pytest.raises(MissionError, match=r"vary.defaults.mass reaches 0.8999.*must be a number in \[0.005, 0.5\] kg"):
        check_ends(whole)


def test_unknown_keys_are_found_before_anything_flies(campaign):
    whole = campaign(vary={"defaults.weight": {"uniform": [0.02, 0.03]}}, flights=3)
    with pytest.raises(MissionError, match="has no key 'weight'"):
        check_ends(whole)


def test_a_mission_file_is_a_campaign_with_the_spread_of_real_vehicles(hop):
    whole = load_campaign(hop, flights=4)
    check_ends(whole)
    keys = [varied.key for varied in whole.varied]
    assert "drones[0].vehicle.rotors.thrust_scale" in keys
    assert "drones[0].vehicle.trim.torque[2]" in keys
    assert all(varied.source for varied in whole.varied)
    job = whole.job(0, whole.values_at([0.0] * len(keys)))
    mission = load_mission(job.mission, changes=job.changes, seed=job.seed)
    assert mission.fleet[0].vehicle["rotors.thrust_scale"] == pytest.approx(0.89)
    assert mission.fleet[0].vehicle["trim.torque"] == pytest.approx((-1e-3, -1e-3, -1.7e-4))


def test_drones_of_a_layout_vary_one_by_one(hop):
    text = hop.read_text().replace("- id: cf1\n  position:\n  - 0.0\n  - 0.0\n", "  count: 3\n  spacing: 1.0\n")
    hop.write_text(text)
    whole = load_campaign(hop, flights=2)
    job = whole.job(1, whole.rows()[1])
    fleet = load_mission(job.mission, changes=job.changes, seed=job.seed).fleet
    assert len({drone.mass for drone in fleet}) == 3


def test_seeds_and_values_depend_on_campaign_and_number_alone(campaign):
    vary = {"defaults.battery": {"uniform": [0.5, 1.0]}}
    short, long = campaign(vary=vary, flights=3), campaign(vary=vary, flights=6)
    assert short.rows() == long.rows()[:3]
    assert [short.job(n, short.rows()[n]) for n in range(3)] == [long.job(n, long.rows()[n]) for n in range(3)]
    assert campaign(vary=vary, flights=3, seed=1).rows() != short.rows()


def test_a_seed_may_be_varied_like_anything_else(campaign):
    whole = campaign(vary={"seed": {"choice": [11, 12]}}, flights=20)
    assert {whole.job(n, row).seed for n, row in enumerate(whole.rows())} == {11, 12}


def test_correlated_values_go_together(campaign):
    keys = ["defaults.mass", "defaults.battery"]
    whole = campaign(
        vary={keys[0]: {"normal": {"mean": 0.03, "std": 0.001}}, keys[1]: {"uniform": [0.5, 1.0]}},
        correlated=[{"keys": keys, "correlation": 0.8}],
        flights=2000,
    )
    found = np.array([list(row.values()) for row in whole.rows()])
    ranks = found.argsort(axis=0).argsort(axis=0)
    assert np.corrcoef(ranks.T)[0, 1] == pytest.approx(6.0 / math.pi * math.asin(0.4), abs=0.03)
    alone = correlate(shares("monte_carlo", 2000, 2, 0), whole.varied, ())
    np.testing.assert_array_equal(alone, shares("monte_carlo", 2000, 2, 0))


def init(*words):
    return CliRunner().invoke(app, ["campaign", "init", *map(str, words)])


def test_a_campaign_file_is_written_beside_a_mission(hop):
    result = init(hop)
    assert result.exit_code == 0, result.output
    path = hop.with_name("hop_campaign.yaml")
    assert f"fly it with: crazychoir campaign {path}" in result.output
    whole = load_campaign(path)
    assert whole.mission_file == hop and whole.settings.flights == 300
    assert whole.varied == load_campaign(hop).varied

    # what is commented out is the same, and right
    text = path.read_text()
    assert "#   rms_error_m: {quantile: 0.95, max: 0.1}" in text
    begin = text.index("# vary:")
    end = text.index("\n\n", begin)
    path.write_text(text[:begin] + "\n".join(line[2:] for line in text[begin:end].splitlines()) + text[end:])
    named = {one.key: one.distribution for one in load_campaign(path).varied}
    for one in whole.varied:
        for share in (0.1, 0.5, 0.9):
            assert named[one.key].at(share) == pytest.approx(one.distribution.at(share), rel=1e-5)


def test_a_campaign_file_knows_the_limits_of_its_mission(tmp_path):
    mission = Path(__file__).parents[2] / "examples/bearing_formation.yaml"
    assert init(mission, "--out", tmp_path / "c.yaml").exit_code == 0
    text = (tmp_path / "c.yaml").read_text()
    assert "#   min_distance_m: {quantile: 0.95, min: 0.3}\n#   bearing_error_deg: {quantile: 0.95, max: 1}\n" in text
    assert "the others have 51 entries like these" in text
    assert load_campaign(tmp_path / "c.yaml").mission.name == "bearing_formation"


def test_a_campaign_file_is_never_overwritten(hop):
    path = hop.with_name("hop_campaign.yaml")
    path.write_text("mine")
    result = init(hop)
    assert result.exit_code == 2
    assert "is there already, and stays as it is" in result.stderr
    assert path.read_text() == "mine"
    other = hop.with_name("deeper")
    other.mkdir()
    assert init(hop, "--out", other / "c.yaml").exit_code == 0
    assert load_campaign(other / "c.yaml").mission.name == "hop"
    assert init(hop.with_name("none.yaml")).exit_code == 2
    assert "No such file" in init(hop, "--out", hop.with_name("no") / "c.yaml").stderr


@pytest.mark.parametrize(
    "given_",
    [{"choice": ["a", [1, 2]]}, {"uniform": [0.5, 2]}, {"triangular": [0, 1, 2], "low": 0.5},
     {"log_uniform": [0.1, 10]}, {"normal": {"mean": 1, "std": 2}, "high": 3}],
)  # fmt: skip
def test_distributions_are_written_as_they_are_read(given_):
    found = read_distribution("vary.x", given_)
    assert read_distribution("vary.x", yaml.safe_load(written(found))) == found


def test_what_decides_flights_is_what_a_campaign_is_known_by(hop):
    folder = hop.parent
    hop.write_text(hop.read_text().replace("id: cf1", "id: cf1\n  motor_ctrl: law.py:Law\n  app: [mine.c]"))
    for name in ("law.py", "helper.py", "mine.c", "mine.h", "notes.csv", "other.yaml"):
        (folder / name).write_text("a")
    named = named_files(hop, ())
    assert {path.name for path in named} == {"law.py", "helper.py", "mine.c", "mine.h"}
    assert {path.name for path in named_files(hop, ["scene=other.yaml"])} >= {"other.yaml"}


def test_changed_firmware_makes_another_campaign(hop, monkeypatch):
    whole, content = load_campaign(hop), "one"
    flown = replace(whole, variant=Variant(provider="bitcraze"))
    monkeypatch.setattr(known_by, "locate", lambda folder: folder)
    monkeypatch.setattr(known_by, "build_provider", lambda *_, **__: SimpleNamespace(identity={"content": content}))
    first = identity_of(flown)
    assert identity_of(flown) == first != identity_of(whole)
    content = "two"
    assert identity_of(flown) != first
    builtin = identity_of(whole)
    hop.write_text(hop.read_text().replace("height: 0.5", "height: 0.6"))
    assert identity_of(whole) != builtin
