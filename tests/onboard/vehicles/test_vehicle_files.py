"""The YAML files of the vehicles, and what users may write in their place."""

import importlib.util
from pathlib import Path

import mujoco
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from crazychoir_fw._core import ffi, lib
from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.mujoco_models import model_path
from crazychoir_fw.onboard import vehicles

ROOT = Path(__file__).parents[3]
NUMBERS = {"cf2": lib.CF_PLATFORM_CF2, "cf21bl": lib.CF_PLATFORM_CF21BL}


def config_of(platform, text=""):
    config = ffi.new("cf_vehicle_config_t *")
    assert lib.cf_vehicle_default_config(config, NUMBERS[platform]) == lib.CF_OK
    message = ffi.new("char[]", lib.CF_PARAMETER_MESSAGE_BYTES)
    return config, lib.cf_parameters_set(config, text.encode(), message), ffi.string(message).decode(errors="replace")


def values_of(config):
    read = ffi.new("float[]", lib.CF_PARAMETER_MAX_SIZE)
    sizes = [(i, lib.cf_parameter_get(config, i, read)) for i in range(lib.cf_parameter_count())]
    table = {}
    for i, size in sizes:
        lib.cf_parameter_get(config, i, read)
        table[ffi.string(lib.cf_parameter_facts(i).name).decode()] = list(read[0:size])
    return table


def as_numbers(parameter):
    if parameter.choices:
        return [parameter.choices.index(parameter.value)]
    return list(parameter.value) if parameter.size > 1 else [parameter.value]


def test_c_table_is_current():
    spec = importlib.util.spec_from_file_location("airframe_table", ROOT / "bindings/vehicle/airframe_table.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert (ROOT / "bindings/vehicle/airframe_table.c").read_text() == module.table()


@pytest.mark.parametrize("platform", NUMBERS)
def test_c_has_every_parameter_with_its_value(platform):
    config, _, _ = config_of(platform)
    in_c = values_of(config)
    files = vehicles.parameters(platform)
    assert list(in_c) == list(files)
    for name, parameter in files.items():
        assert in_c[name] == pytest.approx(as_numbers(parameter), rel=1e-6), name


@pytest.mark.parametrize("platform", NUMBERS)
def test_plant_and_onboard_software_share_the_thrust_curve(platform):
    curve = lib.cf_platform_facts(NUMBERS[platform]).thrust
    files = vehicles.parameters(platform)
    assert files["rotors.thrust_curve"].value == pytest.approx((curve.c0, curve.c1, curve.c2, curve.c3), rel=1e-6)
    assert files["mass"].value == pytest.approx(lib.cf_platform_facts(NUMBERS[platform]).mass)


@pytest.mark.parametrize("platform", NUMBERS)
def test_body_of_the_model_has_mass_and_inertia_of_the_file(platform):
    model = mujoco.MjModel.from_xml_path(str(model_path(platform)))
    body = model.body("crazyflie")
    files = vehicles.parameters(platform)
    assert body.mass[0] == pytest.approx(files["mass"].value)
    assert sorted(body.inertia) == pytest.approx(sorted(files["inertia"].value))


@pytest.mark.parametrize("platform", NUMBERS)
def test_every_value_has_unit_source_and_a_range_around_it(platform):
    for parameter in vehicles.parameters(platform).values():
        assert parameter.source
        assert parameter.meaning
        assert all(parameter.lowest <= number <= parameter.highest for number in as_numbers(parameter))


@pytest.mark.parametrize("name", vehicles.NAMED)
def test_named_vehicles_hold_known_parameters(name):
    assert vehicles.overrides(name)


@pytest.mark.parametrize(
    ("source", "expected"),
    [
        ({"rotors.thrust_scale": 0.9}, {"rotors.thrust_scale": 0.9}),
        ({"rotors": {"thrust_scale": 0.9}}, {"rotors.thrust_scale": 0.9}),
        ({"trim.torque": ["1e-4", 0, 0]}, {"trim.torque": (1e-4, 0.0, 0.0)}),
        ({"trim": {"torque": np.array([1e-4, 0, 0])}}, {"trim.torque": (1e-4, 0.0, 0.0)}),
        ({"downwash.enabled": False}, {"downwash.enabled": "off"}),
        ({"mass": {"value": 0.03, "unit": "kg"}}, {"mass": 0.03}),
        ({"rotors.time_constant": 0.1}, {"rotors.time_constant_up": 0.1, "rotors.time_constant_down": 0.1}),
    ],
)
def test_overrides_may_be_written_in_several_ways(source, expected):
    assert vehicles.overrides(source) == expected


def test_later_sources_win(tmp_path):
    (tmp_path / "mine.yaml").write_text("mass: 0.031\nwind: {velocity: [1, 0, 0]}\n")
    found = vehicles.overrides(["nanobench", "mine.yaml", {"mass": 0.032}], folder=tmp_path)
    assert found["mass"] == 0.032
    assert found["wind.velocity"] == (1.0, 0.0, 0.0)
    assert found["rotors.thrust_scale"] == 0.92


@pytest.mark.parametrize(
    ("source", "error", "words"),
    [
        ({"rotor.law": "quadratic"}, UnknownNameError, "did you mean 'rotors.law'"),
        ({"mass": 3}, RangeError, "allowed: 0.005 to 0.5 kg"),
        ({"mass": True}, RangeError, "mass is 'True'"),
        ({"mass": float("nan")}, RangeError, "mass is 'nan'"),
        ({"rotors.law": "cubic"}, RangeError, "first_order | quadratic"),
        ({"trim.torque": [0, 0]}, RangeError, "3 numbers, each -0.01 to 0.01 N m"),
        ({"rotors.duty_bits": 8.5}, RangeError, "whole number 1 to 16 bit"),
        ("nowhere.yaml", UnknownNameError, "neither a file nor one of: kit, legacy, nanobench"),
        (3, RangeError, "allowed: parameters, a YAML file"),
    ],
)
def test_what_cannot_be_is_refused_in_words(source, error, words):
    with pytest.raises(error) as caught:
        vehicles.overrides(source)
    assert words in str(caught.value)


@pytest.mark.parametrize("text", ["[1, 2]", "a: [", "\x00"])
def test_file_without_parameters_is_refused(tmp_path, text):
    path = tmp_path / "odd.yaml"
    path.write_text(text)
    with pytest.raises(RangeError, match=r"odd\.yaml"):
        vehicles.overrides(path)


@pytest.mark.parametrize(
    ("text", "status", "words"),
    [
        ("", lib.CF_OK, ""),
        ("  mass=0.03\n trim.torque=1e-4,0,-1e-4 ", lib.CF_OK, ""),
        ("rotors.time_constant=0.1", lib.CF_OK, ""),
        ("mass=0.03 nothing=1", lib.CF_ERR_UNKNOWN, "no parameter 'nothing'"),
        ("mass=nan", lib.CF_ERR_VALUE, "allowed: 0.005 to 0.5 kg"),
        ("mass=0.03,0.03", lib.CF_ERR_VALUE, "mass is '0.03,0.03'"),
        ("mass=0.03,", lib.CF_ERR_VALUE, "mass is '0.03,'"),
        ("mass", lib.CF_ERR_VALUE, "mass is ''"),
        ("inertia=1e-5,1e-5", lib.CF_ERR_VALUE, "3 numbers with commas between"),
        ("drag.form=square", lib.CF_ERR_VALUE, "none | linear | rotor"),
        ("rotors.duty_bits=8.5", lib.CF_ERR_VALUE, "whole number 1 to 16"),
    ],
)
def test_text_of_the_plugin(text, status, words):
    _, result, message = config_of("cf2", text)
    assert result == status
    assert words in message


@given(st.text(max_size=200).filter(lambda text: "\x00" not in text))
def test_no_text_does_harm(text):
    _, status, message = config_of("cf2", text)
    assert status in (lib.CF_OK, lib.CF_ERR_VALUE, lib.CF_ERR_UNKNOWN)
    assert (status == lib.CF_OK) or message


@given(st.floats(0.005, 0.5), st.floats(0.001, 1), st.tuples(*[st.floats(-0.01, 0.01)] * 3))
def test_text_and_back(mass, constant, trim):
    chosen = vehicles.overrides({"mass": mass, "rotors.time_constant_up": constant, "trim.torque": trim})
    config, status, message = config_of("cf2", vehicles.as_text(chosen))
    assert status == lib.CF_OK, message
    values = values_of(config)
    assert values["mass"] == [np.float32(mass)]
    assert values["rotors.time_constant_up"] == [np.float32(constant)]
    assert values["trim.torque"] == [np.float32(number) for number in trim]
