"""`crazychoir new`: a starting point that flies at once."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from crazychoir_fw.cli.console import console, refuse
from crazychoir_fw.common.shared_folders import shared_folder


@dataclass(frozen=True)
class _Kind:
    """What is written for one kind of starting point; `{name}` and `{Name}` are those of the user."""

    files: dict[str, str]
    """File of the repository to the file that it becomes."""
    words: dict[str, str]
    """What is replaced in the files."""
    command: str
    """What flies it."""


_BINARY = ".npz"
_FLY = "crazychoir fly {name}/{name}.yaml"
KINDS = {
    "mission": _Kind(
        {"examples/hello_swarm.yaml": "{name}.yaml"},
        {"examples/hello_swarm.yaml": "{name}/{name}.yaml", "name: hello_swarm": "name: {name}"},
        _FLY,
    ),
    "guidance": _Kind(
        {"examples/new_law/mission.yaml": "{name}.yaml", "examples/new_law/rendezvous.py": "{name}.py"},
        {"rendezvous.py": "{name}.py", "Rendezvous": "{Name}"},
        _FLY,
    ),
    "controller": _Kind(
        {
            "examples/new_controller/compare.yaml": "{name}.yaml",
            "examples/new_controller/tilt_prioritized.c": "{name}.c",
            "examples/figure8.csv": "figure8.csv",
        },
        {
            "#\n# `python examples/new_controller/compare.py` flies the same and draws both into one picture.\n": "",
            "examples/new_controller/compare.yaml": "{name}/{name}.yaml",
            "name: new_controller": "name: {name}",
            "tilt_prioritized.c": "{name}.c",
            "../figure8.csv": "figure8.csv",
        },
        _FLY,
    ),
    "app": _Kind(
        {"examples/app_task/hop.c": "{name}.c", "examples/app_task/hop.py": "{name}.py"},
        {"hop.c": "{name}.c", ": see README.md": ", named by CRAZYFLIE_FIRMWARE"},
        "CRAZYFLIE_FIRMWARE=CHECKOUT python {name}/{name}.py",
    ),
    "policy": _Kind(
        {"examples/learning/hover.yaml": "{name}.yaml", "examples/learning/hover.npz": "{name}.npz"},
        {
            "#   python examples/learning/train.py hover\n": "",
            "out/learning/hover/policy.npz": "{name}/{name}.npz",
            "--out examples/learning --name hover": "--out {name} --name {name}",
            "examples/learning/hover.yaml": "{name}/{name}.yaml",
            "# hover.c lies here as it was trained. Below": "# The first line writes {name}.c. Below",
            "name: learned_hover": "name: {name}",
            "from examples/learning/train.py ": "",
            "hover.c": "{name}.c",
        },
        "crazychoir app from-policy {name}/{name}.npz --out {name} --name {name} && " + _FLY,
    ),
    "scene": _Kind(
        {"examples/gates.yaml": "{name}.yaml", "mujoco_models/scene_gates.xml": "{name}.xml"},
        {
            "examples/gates.yaml": "{name}/{name}.yaml",
            "name: gates": "name: {name}",
            "scene: gates": "scene: {name}.xml",
            "The scene `gates`": "The scene {name}.xml",
        },
        _FLY,
    ),
}


def new(
    kind: Annotated[str, typer.Argument(help=", ".join(KINDS), metavar="KIND")],
    name: Annotated[str, typer.Argument(help="Folder that is made, and name of the files in it.", metavar="NAME")],
) -> None:
    """Write a commented starting point that flies at once."""
    if kind not in KINDS:
        refuse(f"there is no kind '{kind[:40]}', allowed: {', '.join(KINDS)}")
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]{0,39}", name):
        refuse(f"name is '{name[:60]}', but must be a letter and up to 39 letters, digits and _")
    folder = Path(name)
    try:
        folder.mkdir()
        for file in _write(KINDS[kind], name, folder):
            console.print(f"{file}", markup=False, highlight=False)
    except FileExistsError:
        refuse(f"{folder} is there already: give another name")
    except OSError as error:
        refuse(f"{error.filename or folder} cannot be written: {error.strerror}")
    command = KINDS[kind].command.format(name=name)
    console.print(f"fly it with: {command}", markup=False, highlight=False, soft_wrap=True)


def _write(kind: _Kind, name: str, folder: Path) -> list[Path]:
    """Write the files of a starting point; returns them."""
    class_name = "".join(word[:1].upper() + word[1:] for word in name.split("_"))
    written = []
    for source, target in kind.files.items():
        shared, _, file = source.partition("/")
        content = (shared_folder(shared) / file).read_bytes()
        if not file.endswith(_BINARY):
            text = content.decode()
            for old, replacement in kind.words.items():
                text = text.replace(old, replacement.format(name=name, Name=class_name))
            content = text.encode()
        written.append(folder / target.format(name=name))
        written[-1].write_bytes(content)
    return written
