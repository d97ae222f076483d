"""Every collected number of the vehicle is reproduced within its band."""

import importlib.util
import sys
from pathlib import Path

import pytest

PATH = Path(__file__).parents[2] / "benchmarks/vehicle_validation.py"
spec = importlib.util.spec_from_file_location("vehicle_validation", PATH)
validation = importlib.util.module_from_spec(spec)
sys.modules[spec.name] = validation
spec.loader.exec_module(validation)


@pytest.mark.parametrize("section", validation.SECTIONS, ids=lambda section: section.__name__)
def test_numbers_of_a_section_are_within_their_bands(section):
    rows = list(section())
    assert rows
    assert [f"{row.quantity}, {row.vehicle}: {row.ours}" for row in rows if not row.is_within] == []


def test_table_in_the_docs_has_every_row():
    page = (PATH.parents[1] / "docs/vehicle.md").read_text()
    fast = [section for section in validation.SECTIONS if section is not validation.flights]
    for row in (row for section in fast for row in section()):
        assert validation.markdown([row]).splitlines()[-1] in page
