"""bindings/bitcraze/api.h: every name of ours that a checkout could have is renamed, and free again afterwards."""

import re
import subprocess

from crazychoir_fw.firmware.own_sources import bindings_folder
from crazychoir_fw.firmware.toolchain import find_compiler

BINDINGS = bindings_folder()
NAME = re.compile(r"\b[A-Za-z_]\w*")


def preprocessed(*arguments):
    command = [*find_compiler().command, "-E", *arguments, f"-I{BINDINGS}", str(BINDINGS / "bitcraze" / "api.h")]
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def test_what_is_renamed_is_free_again():
    text = (BINDINGS / "bitcraze" / "api.h").read_text()
    renamed = re.findall(r"^#define (\w+) api_\1$", text, flags=re.MULTILINE)
    freed = re.findall(r"^#undef (\w+)$", text, flags=re.MULTILINE)
    assert renamed and set(renamed) < set(freed)
    assert len(set(freed)) == len(freed)


def test_no_macro_of_ours_stays():
    """Guards and macros of api/ would keep a checkout's headers out, or change them."""
    left = set(re.findall(r"^#define (\w+)", preprocessed("-dM"), flags=re.MULTILINE))
    ours = set()
    for path in (BINDINGS / "api").glob("*.h"):
        ours |= set(re.findall(r"^#define (\w+)", path.read_text(), flags=re.MULTILINE))
    assert len(ours) > 30
    assert not left & ours


def test_every_name_of_the_headers_that_are_read_is_renamed():
    """What our headers declare has api_ or cf_ before its name: functions, types, tags, enumerators."""
    text = preprocessed()
    pieces = re.findall(r'^# \d+ "(.*?)".*?\n(.*?)(?=^# \d+ "|\Z)', text, flags=re.DOTALL | re.MULTILINE)
    own = "".join(body for name, body in pieces if str(BINDINGS) in name)
    names = {name for body in re.findall(r"enum\s*\w*\s*\{(.*?)\}", own) for name in re.findall(r"(\w+)\s*[=,]", body)}
    names |= set(re.findall(r"\b(?:struct|union|enum)\s+(\w+)\s*\{", own))
    names |= set(re.findall(r"\(\*(\w+)\)", re.sub(r"struct \{.*?\n\}", "", own, flags=re.DOTALL)))
    while (flat := re.sub(r"\{[^{}]*\}", "", own)) != own:
        own = flat
    names |= {match[1] for match in re.finditer(r"(\w+)\s*(?:\(|;)", re.sub(r"\([^()]*\)(?=;)", "(", own))}
    assert len(names) > 100
    assert {name for name in names if not name.startswith(("api_", "cf_", "CF_"))} <= {"_Noreturn", "enum", "float"}
