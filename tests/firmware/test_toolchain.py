import pytest

from crazychoir_fw.common.errors import BuildError
from crazychoir_fw.firmware.toolchain import find_compiler


def script(folder, name, text):
    path = folder / name
    path.write_text(f"#!/bin/sh\n{text}\n")
    path.chmod(0o755)
    return path


def test_the_environment_chooses(tmp_path, monkeypatch):
    path = script(tmp_path, "my-cc", 'echo "my cc 1.0, told $1 $2"; echo more')
    monkeypatch.setenv("CC", f"{path} -m64")
    compiler = find_compiler()
    assert compiler.command == (str(path), "-m64")
    assert compiler.version == "my cc 1.0, told -m64 --version"


def test_what_there_is_is_taken(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    path = script(tmp_path, "clang", "echo clang 99")
    assert find_compiler().command == (str(path),)


def test_no_compiler(tmp_path, monkeypatch):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(BuildError, match="no C compiler found: run `apt install build-essential`"):
        find_compiler()


def test_a_wrong_choice_is_not_replaced_silently(monkeypatch):
    monkeypatch.setenv("CC", "no-such-cc")
    with pytest.raises(BuildError, match="that CC names, 'no-such-cc', is not there"):
        find_compiler()


def test_something_else_than_a_compiler(tmp_path, monkeypatch):
    monkeypatch.setenv("CC", str(script(tmp_path, "cc-broken", "exit 3")))
    with pytest.raises(BuildError, match="does not tell its version"):
        find_compiler()
