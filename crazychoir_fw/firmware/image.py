"""Where the file-scope variables of a compiled provider library are, and which of their words are pointers.

The ranges come from the section table, the pointers from the debug information and from the relocations. Nothing of the
library is executed.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from elftools.elf.constants import SH_FLAGS
from elftools.elf.elffile import ELFFile
from elftools.elf.relocation import RelocationSection, RelrRelocationSection

from crazychoir_fw.common.errors import BuildError, CrazychoirError

Range = tuple[int, int]  # offset from the begin of the library, size [bytes]

WORD = 8  # [bytes]

MAX_BYTES = 262144
"""What the variables of a drone may take, as CF_LIBRARY_MAX_STATE_BYTES of the loader [bytes]."""

_NAMED = 3  # variables that a refusal names

# operations of DWARF: an address follows, or the number of an address in a table
ADDRESS, ADDRESS_BY_NUMBER = 0x03, 0xA1

# the length of an expression, the operation and an address, which may overlap with others that only look alike
_PLACE = re.compile(rb"(?=\x09\x03(.{8}))", re.DOTALL)

# Written by the loader, by the run-time of C, or by the library for itself (CF_LIBRARY_KEEP), and the same for every
# drone. What a drone needs of the tasks' stacks is kept elsewhere (bitcraze/rtos). The two tables are read only when
# the library is opened.
NOT_OF_A_DRONE = {
    ".cf_keep",
    ".cf_stacks",
    ".dynamic",
    ".fini_array",
    ".got",
    ".got.plt",
    ".init_array",
    ".tm_clone_table",
    "cf_logs",
    "cf_parameters",
}

# Variables with less than this between them are one range: copying once is faster than twice.
LARGEST_GAP = 64  # [bytes]

RELATIVE_RELOCATIONS = {"EM_X86_64": 8, "EM_AARCH64": 1027}


def image_map(path: Path | str) -> tuple[list[Range], list[int]]:
    """Return the ranges of memory that belong to a drone, and the offsets of the words there that are pointers.

    Args:
        path: A shared object for this kind of machine, built with ``-g``.

    Returns:
        ``(offset, bytes)`` of each range, in ascending order and apart from each other, and the offsets of the
        pointers, ascending; all offsets count from the begin of the library in memory.

    Raises:
        CrazychoirError: If the file is no such library, has no debug information, or has variables that each thread has
            for itself.
        BuildError: If the variables take more than MAX_BYTES.
    """
    with Path(path).open("rb") as file:
        try:
            elf = ELFFile(file)
        except Exception as error:
            raise CrazychoirError(f"{path} is no shared library that this machine can load: {error}") from error
        _check(elf, path)
        begin = min(segment["p_vaddr"] for segment in elf.iter_segments("PT_LOAD"))
        ranges = [(start - begin, stop - start) for start, stop in _merged(list(_variable_sections(elf)), elf)]
        _check_size(elf, path, ranges, begin)
        places = [(begin + offset, begin + offset + size) for offset, size in ranges]
        words = {address - begin for address in _pointer_variables(elf, places)}
        words.update(address - begin for address in _relative_relocations(elf))
    return ranges, sorted(word for word in words if _lies_in(word, ranges))


def _check(elf: ELFFile, path: Path | str) -> None:
    if elf["e_type"] != "ET_DYN" or elf["e_machine"] not in RELATIVE_RELOCATIONS or elf.elfclass != 64:
        raise CrazychoirError(f"{path} is no shared library for x86-64 or aarch64")
    if elf.get_section_by_name(".debug_info") is None and elf.get_section_by_name(".zdebug_info") is None:
        raise CrazychoirError(
            f"{path} has no debug information, which tells where its variables hold pointers; "
            "compile with -g and do not strip"
        )
    for section in elf.iter_sections():
        if section["sh_flags"] & SH_FLAGS.SHF_TLS and section["sh_size"] > 0:
            raise CrazychoirError(
                f"{path} has variables that each thread has for itself (section {section.name}); "
                "such variables cannot belong to a drone, remove _Thread_local or __thread from them"
            )


def _check_size(elf: ELFFile, path: Path | str, ranges: list[Range], begin: int) -> None:
    """Refuse what no drone could carry, before looking for pointers in it takes minutes."""
    total = sum(size for _, size in ranges)
    if total <= MAX_BYTES:
        return
    largest = sorted(_variables(elf, ranges, begin), key=lambda one: (-one[1], one[0]))[:_NAMED]
    names = ", ".join(f"{name} {size}" for name, size in largest)
    raise BuildError(
        f"the file-scope variables of {Path(path).stem} take {total} bytes per drone, allowed: {MAX_BYTES}; "
        f"the largest: {names}"
    )


def _variables(elf: ELFFile, ranges: list[Range], begin: int) -> Iterator[tuple[str, int]]:
    """Yield name and size of the variables in the ranges; of those that only one source knows, with the source."""
    table = elf.get_section_by_name(".symtab")
    source = ""
    for symbol in table.iter_symbols() if table is not None else ():
        kind, binding = symbol["st_info"]["type"], symbol["st_info"]["bind"]
        if kind == "STT_FILE":
            source = symbol.name
        elif kind == "STT_OBJECT":
            word = symbol["st_value"] - begin
            if any(offset <= word < offset + size for offset, size in ranges):
                # compilers number the static variables of functions
                name = re.sub(r"\.\d+$", "", symbol.name)
                where = f" in {source}" if binding == "STB_LOCAL" and source else ""
                yield f"{name}{where}", symbol["st_size"]


# --------------------------------------------------------------------------------------------------------------- ranges


def _variable_sections(elf: ELFFile) -> Iterator[Range]:
    """Yield (start, stop) addresses of the sections with variables of the code."""
    sealed = [
        (segment["p_vaddr"], segment["p_vaddr"] + segment["p_memsz"]) for segment in elf.iter_segments("PT_GNU_RELRO")
    ]
    needed = SH_FLAGS.SHF_ALLOC | SH_FLAGS.SHF_WRITE
    for section in elf.iter_sections():
        start, size = section["sh_addr"], section["sh_size"]
        is_sealed = any(first <= start < last for first, last in sealed)
        if section["sh_flags"] & needed == needed and size > 0 and not is_sealed and section.name not in NOT_OF_A_DRONE:
            yield start, start + size


def _merged(ranges: list[Range], elf: ELFFile) -> list[Range]:
    """Join neighbors that have nothing but padding between them."""
    occupied = [
        (section["sh_addr"], section["sh_addr"] + section["sh_size"])
        for section in elf.iter_sections()
        if section["sh_flags"] & SH_FLAGS.SHF_ALLOC and section["sh_size"] > 0
    ]
    merged: list[Range] = []
    for start, stop in sorted(ranges):
        last = merged[-1][1] if merged else None
        is_near = last is not None and start - last <= LARGEST_GAP
        if is_near and not any(first < start and last < end for first, end in occupied):
            merged[-1] = (merged[-1][0], stop)
        else:
            merged.append((start, stop))
    return merged


def _lies_in(word: int, ranges: list[Range]) -> bool:
    return any(offset <= word and word + WORD <= offset + size for offset, size in ranges)


# ------------------------------------------------------------------------------------------------------------- pointers


def _relative_relocations(elf: ELFFile) -> Iterator[int]:
    """Yield the addresses of words that the loader makes into pointers into the library."""
    relative = RELATIVE_RELOCATIONS[elf["e_machine"]]
    for section in elf.iter_sections():
        if isinstance(section, RelrRelocationSection):
            yield from (relocation["r_offset"] for relocation in section.iter_relocations())
        elif isinstance(section, RelocationSection):
            for relocation in section.iter_relocations():
                if relocation["r_info_type"] == relative:
                    yield relocation["r_offset"]


def _pointer_variables(elf: ELFFile, places: list[Range]) -> Iterator[int]:
    """Yield the addresses of all pointers in variables of static storage, within arrays, structs and unions too.

    Args:
        elf: The library.
        places: (start, stop) addresses of the variables that matter.
    """
    dwarf = elf.get_dwarf_info()
    layouts: dict[int, list[int]] = {}
    for unit in dwarf.iter_CUs():
        # reading the words of a unit one by one takes a thousand times as long as looking for an address among them,
        # unless addresses stand in a table of their own
        if dwarf.debug_addr_sec is None and not _mentions_address(bytes_of_unit(dwarf, unit), places):
            continue
        for die in unit.iter_DIEs():
            if die.tag == "DW_TAG_variable":
                address = address_of_variable(die)
                if address is not None:
                    yield from (address + offset for offset in _pointers_in(_type(die), layouts))


def bytes_of_unit(dwarf: Any, unit: Any) -> bytes:
    """Return the debug information of one source as it stands in the file."""
    stream = dwarf.debug_info_sec.stream
    stream.seek(unit.cu_offset)
    return bytes(stream.read(unit.size))


def _mentions_address(data: bytes, places: list[Range]) -> bool:
    """Tell whether the place of a variable in one of the ranges may be written in there."""
    found = (int.from_bytes(match, "little") for match in _PLACE.findall(data))
    return any(first <= address < last for address in found for first, last in places)


def address_of_variable(die: Any) -> int | None:
    """Return where a variable lives, or None when it has no fixed address."""
    location = die.attributes.get("DW_AT_location")
    # numbers stand for tables of places by time, which variables of static storage do not need
    if location is None or not isinstance(location.value, list) or not location.value:
        return None
    operation, *operands = location.value
    if operation == ADDRESS and len(operands) == WORD:
        return int.from_bytes(bytes(operands), "little")
    if operation == ADDRESS_BY_NUMBER and _is_one_number(operands):
        number = sum((byte & 0x7F) << (7 * i) for i, byte in enumerate(operands))
        return die.dwarfinfo.get_addr(die.cu, number)
    return None


def _is_one_number(operands: list[int]) -> bool:
    """Return whether the bytes are one number of variable length, and nothing behind it."""
    return [byte >> 7 for byte in operands] == [1] * (len(operands) - 1) + [0]


def _type(die: Any) -> Any | None:
    """Return the type of a variable, member or type, which may stand with its declaration elsewhere."""
    for attribute in ("DW_AT_type", "DW_AT_abstract_origin", "DW_AT_specification"):
        if attribute in die.attributes:
            other = die.get_DIE_from_attribute(attribute)
            return other if attribute == "DW_AT_type" else _type(other)
    return None


def _pointers_in(kind: Any | None, layouts: dict[int, list[int]]) -> list[int]:
    """Return the offsets of the pointers in a value of this type."""
    if kind is None:
        return []
    if kind.offset not in layouts:
        layouts[kind.offset] = list(_find_pointers(kind, layouts))
    return layouts[kind.offset]


def _find_pointers(kind: Any, layouts: dict[int, list[int]]) -> Iterator[int]:
    if kind.tag == "DW_TAG_pointer_type":
        yield 0
    elif kind.tag == "DW_TAG_array_type":
        size = _size(_type(kind))
        for i in range(_length(kind)):
            yield from (i * size + offset for offset in _pointers_in(_type(kind), layouts))
    elif kind.tag in ("DW_TAG_structure_type", "DW_TAG_union_type", "DW_TAG_class_type"):
        for member in kind.iter_children():
            if member.tag == "DW_TAG_member" and "DW_AT_data_bit_offset" not in member.attributes:
                start = _value(member, "DW_AT_data_member_location", 0)
                yield from (start + offset for offset in _pointers_in(_type(member), layouts))
    elif kind.tag != "DW_TAG_subroutine_type":  # a typedef, or const, volatile and the like
        yield from _pointers_in(_type(kind), layouts)


def size_of_variable(die: Any) -> int:
    """Return the size of a variable [bytes]."""
    return _size(_type(die))


def _value(die: Any, attribute: str, otherwise: int) -> int:
    value = die.attributes[attribute].value if attribute in die.attributes else otherwise
    return value if isinstance(value, int) else otherwise


def _length(array: Any) -> int:
    """Return the number of elements of an array, of all its dimensions together."""
    length = 1
    for dimension in array.iter_children():
        if dimension.tag == "DW_TAG_subrange_type":
            length *= _value(dimension, "DW_AT_count", _value(dimension, "DW_AT_upper_bound", -1) + 1)
    return length


def _size(kind: Any | None) -> int:
    """Return the size of a value of this type [bytes]."""
    if kind is None:
        return 1
    if kind.tag == "DW_TAG_array_type" and "DW_AT_byte_size" not in kind.attributes:
        return _length(kind) * _size(_type(kind))
    otherwise = WORD if kind.tag == "DW_TAG_pointer_type" else -1
    size = _value(kind, "DW_AT_byte_size", otherwise)
    return size if size >= 0 else _size(_type(kind))
