"""Tables of contents (docs/reference/crtp-cflib.md#8.1, #8.4, #9.1 and #9.2)."""

import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest
from cflib.crazyflie.log import LogTocElement
from cflib.crazyflie.param import ParamTocElement

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.crtp.toc import TableOfContents, log_entry, log_toc, parameter_entry, parameter_toc
from crazychoir_fw.onboard.variables import Variable, log_table, parameter_table

PLAIN = Variable("group.name", np.dtype(np.uint8), 0, is_core=False, is_persistent=False, is_read_only=False)


def table(*variables, entry=parameter_entry, kind="parameter"):
    return TableOfContents(kind, [entry(variable) for variable in variables])


def test_it_tells_how_many_there_are():
    toc = parameter_toc()
    assert struct.unpack("<BHL", toc.answer(b"\x03")) == (3, len(parameter_table()), toc.crc)
    toc = log_toc()
    assert struct.unpack("<BHLBB", toc.answer(b"\x03")) == (3, len(log_table()), toc.crc, 16, 128)


@pytest.mark.parametrize(("toc", "element"), [(log_toc(), LogTocElement), (parameter_toc(), ParamTocElement)])
def test_cflib_understands_every_item(toc, element):
    types = {"uint8_t": "u1", "uint16_t": "u2", "uint32_t": "u4", "int8_t": "i1", "int16_t": "i2", "int32_t": "i4"}
    for number, variable in enumerate(toc.variables):
        answer = toc.answer(struct.pack("<BH", 2, number))
        assert struct.unpack("<BH", answer[:3]) == (2, number)
        assert len(answer) <= 30
        read = element(number, answer[3:])
        assert f"{read.group}.{read.name}" == variable.name
        assert types.get(read.ctype, "f4") == variable.dtype.str[1:]
        if element is ParamTocElement:
            assert (read.access == ParamTocElement.RO_ACCESS) == variable.is_read_only
            assert read.is_extended() == variable.is_persistent


@pytest.mark.parametrize(
    ("changes", "byte"),
    [
        ({}, 0x08),
        ({"is_persistent": True}, 0x18),
        ({"is_core": True}, 0x28),
        ({"is_read_only": True}, 0x48),
        ({"dtype": np.dtype(np.uint16)}, 0x09),
        ({"dtype": np.dtype(np.uint32)}, 0x0A),
        ({"dtype": np.dtype(np.int8)}, 0x00),
        ({"dtype": np.dtype(np.int16)}, 0x01),
        ({"dtype": np.dtype(np.int32)}, 0x02),
        ({"dtype": np.dtype(np.float32)}, 0x06),
    ],
)
def test_type_byte_of_a_parameter(changes, byte):
    assert table(replace(PLAIN, **changes)).answer(b"\x02\0\0") == b"\x02\0\0" + bytes((byte,)) + b"group\0name\0"


def test_type_byte_of_a_log_variable_has_no_flags():
    logs = table(replace(PLAIN, is_core=True, dtype=np.dtype(np.float32)), entry=log_entry, kind="log")
    assert logs.answer(b"\x02\0\0") == b"\x02\0\0\x07group\0name\0"


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        (b"\x02\xff\xff", b"\x02"),  # no such variable
        (b"\x02\0", b"\x02"),
        (b"\x01", b"\x01\0\0\0"),  # commands with numbers of one byte
        (b"\x00\x00", b"\x00"),
        (b"\x04", None),
        (b"", None),
    ],
)
def test_other_requests(request_, answer):
    assert parameter_toc().answer(request_) == answer


def test_checksums_of_logs_and_parameters_differ_even_when_the_tables_do_not():
    assert log_toc().crc != parameter_toc().crc
    assert table().crc != table(kind="log").crc
    assert table(PLAIN).crc != table(PLAIN, kind="log").crc


@pytest.mark.parametrize("entry", [log_entry, parameter_entry])
def test_checksum_changes_with_everything(entry):
    other = replace(PLAIN, name="group.other")
    changed = [
        table(PLAIN, entry=entry),
        table(PLAIN, other, entry=entry),
        table(other, PLAIN, entry=entry),
        table(replace(PLAIN, name="group2.name"), entry=entry),
        table(replace(PLAIN, name="groupn.ame"), entry=entry),
        table(replace(PLAIN, dtype=np.dtype(np.int8)), entry=entry),
        table(replace(PLAIN, is_core=True), entry=entry),
    ]
    assert len({toc.crc for toc in changed}) == len(changed)


def test_checksum_is_stable():
    assert table(PLAIN).crc == zlib.crc32(b"parameter" + b"\0\0\x08\0group\0name\0")


def test_a_name_that_fits_into_no_packet_is_refused():
    table(replace(PLAIN, name="g" * 12 + "." + "n" * 12))
    with pytest.raises(RangeError, match="25 characters in group and name, at most 24"):
        table(replace(PLAIN, name="g" * 12 + "." + "n" * 13))
