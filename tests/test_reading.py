"""Files and YAML of others: read within limits, or refused in one sentence on one line."""

import os

import pytest

from crazychoir_fw.common.errors import MissionError
from crazychoir_fw.common.plain_yaml import DEEPEST, MOST_NODES, parse_yaml, read_yaml
from crazychoir_fw.common.reading import printable, read_bytes, read_text


def test_a_regular_file_up_to_the_limit_is_read(tmp_path):
    (tmp_path / "a").write_bytes(b"12345")
    assert read_bytes(tmp_path / "a", 5, MissionError) == b"12345"
    with pytest.raises(MissionError, match=r"a is larger than 4 bytes, the allowed maximum"):
        read_bytes(tmp_path / "a", 4, MissionError)


def test_what_is_no_regular_file_is_refused_at_once(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "loop").symlink_to("loop")
    kinds = {
        tmp_path / "pipe": "it is a pipe, but must be a regular file",
        tmp_path: "it is a folder",
        "/dev/zero": "it is a device",
        tmp_path / "loop": "cannot be read: Too many levels of symbolic links",
        tmp_path / "gone": "cannot be read: No such file",
        tmp_path / "line\nbreak": "line break cannot be read",
        "nul\0": r"nul\x00 is no file name",
    }
    for path, says in kinds.items():
        with pytest.raises(MissionError) as caught:
            read_text(path, 100, MissionError)
        assert says in str(caught.value)
        assert str(caught.value).isprintable()


def test_texts_of_others_become_one_printable_line():
    assert printable("a\nb\x1b[31m\u202e\udc80é") == r"a b\x1b[31m\u202e\udc80é"
    assert printable("x" * 100, 10) == "x" * 9 + "…"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("a: &a [*a]", "line 1, column 8: the alias *a stands inside of what it stands for"),
        ("a: &a {b: {c: *a}}", "the alias *a stands inside"),
        (
            "a0: &a0 [x, x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}, *a{i - 1}]\n" for i in range(1, 40)),
            "line 17, column 22: more",
        ),
        ("[" + "a, " * MOST_NODES + "]", f"more than {MOST_NODES} keys and values"),
        ("[" * (DEEPEST + 1) + "]" * (DEEPEST + 1), f"nested deeper than {DEEPEST} levels"),
        (
            "a0: &a0 [x]\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 99)),
            f"deeper than {DEEPEST} levels",
        ),
        ("a: " + "x" * 20_001, "column 4: a text of 20001 characters, allowed: at most 20000"),
        ("a: 1\nb: 2\na: 3", "line 3, column 1: the key 'a' stands here a second time"),
        ("é: 1\nb: \x02", r"line 2: the character '\x02' cannot stand in YAML"),
        ("a: [1,\n\n", "line 1: did not find expected node content"),
        ("a: !!python/object:os.system {}", "could not determine a constructor"),
    ],
    ids=lambda value: value[:20],
)
def test_yaml_beyond_a_limit_is_refused_with_its_line(text, says):
    with pytest.raises(MissionError) as caught:
        parse_yaml(text, "mine.yaml", MissionError)
    assert says in str(caught.value)
    assert str(caught.value).startswith("mine.yaml, line")
    assert str(caught.value).isprintable()


def test_aliases_and_merges_within_the_limits_are_data(tmp_path):
    (tmp_path / "a.yaml").write_text("a: &a {x: 1, y: [1, 2]}\nb: {<<: *a, x: 2}\nc: [*a, *a]\n")
    inner = {"x": 1, "y": [1, 2]}
    assert read_yaml(tmp_path / "a.yaml", MissionError) == {"a": inner, "b": {"x": 2, "y": [1, 2]}, "c": [inner, inner]}
    deepest = "[" * DEEPEST + "]" * DEEPEST
    assert parse_yaml(deepest, "", MissionError) is not None
