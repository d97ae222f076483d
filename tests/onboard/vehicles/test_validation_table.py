"""Every collected number of the vehicle is reproduced within its band."""

import json
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
sys.path.insert(0, str(ROOT / "benchmarks"))
import vehicle_validation as validation  # noqa: E402


@pytest.mark.parametrize("section", validation.SECTIONS, ids=lambda section: section.__name__)
def test_numbers_of_a_section_are_within_their_bands(section):
    rows = list(section())
    assert rows
    assert [f"{row.quantity}, {row.vehicle}: {row.ours}" for row in rows if not row.is_within] == []


def test_table_in_the_docs_has_every_row():
    page = (ROOT / "docs/vehicle.md").read_text()
    flown = (validation.steps, validation.flights)
    for row in (row for section in validation.SECTIONS if section not in flown for row in section()):
        assert validation.markdown([row]).splitlines()[-1] in page


def test_the_script_writes_table_and_plots(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(validation, "SECTIONS", (validation.thrust_curves,))
    files = {"--json": tmp_path / "rows.json", "--markdown": tmp_path / "rows.md", "--plots": tmp_path}
    monkeypatch.setattr(sys, "argv", ["vehicle_validation.py", *(str(word) for pair in files.items() for word in pair)])
    validation.main()
    assert "16 numbers, 0 outside of their band" in capsys.readouterr().out
    assert len(json.loads(files["--json"].read_text())) == 16
    assert files["--markdown"].read_text().startswith("| § | quantity |")
    assert (tmp_path / "vehicle_effects.png").stat().st_size > 10_000
