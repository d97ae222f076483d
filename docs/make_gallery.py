"""Flies every scenario of the original and writes docs/gallery.md with their figures.

    python docs/make_gallery.py                  # all of them
    python docs/make_gallery.py formation_webots # some of them; the others keep what the page says

Scenarios are the files in examples/crazychoir, and those that ChoiRbot has besides.
Real drones are simulated here.
"""

from __future__ import annotations

import argparse
import io
import json
import os
import tempfile
import traceback
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "gallery.md"
IMAGES = ROOT / "docs" / "images" / "gallery"
RESULTS = IMAGES / "results.json"

SCENARIOS = (
    *("formation_rviz", "formation_webots", "formation_vicon", "letter_formation_webots", "huge_formation_webots"),
    *("tracking_webots", "tracking_vicon", "task_assignment_webots", "task_assignment_vicon", "goto_webots"),
    *("collision_webots", "collision_webots_vel", "aggregative_webots", "aggregative_moving_intruders_webots"),
    *("aggregative_lighthouse", "aggregative_moving_intruders_mixed"),
)
BESIDES = ("distance_formation", "containment", "containment_time_varying", "mpc", "pickup_delivery", "swap_ten")

WIDTH = 900  # pixels of a figure
COLORS = 256
LARGEST = 150_000  # bytes of a figure, so that all together stay below 3 MB

HEAD = """# Gallery

Every scenario of the original, and what ChoiRbot has besides, as one mission file each.
The backend `sim` is MuJoCo with the onboard software in the loop; files for real drones are flown here with it, too.
Any of them can be varied: `--seed 3`, `--set layers.guidance.gains=webots`, `--backend integrator`; see
[variants](missions.md#variants).

`python docs/make_gallery.py` flies them again and writes this page.
"""


def path_of(name: str) -> Path:
    """Return the mission file of a scenario."""
    return ROOT / "examples" / ("crazychoir" if name in SCENARIOS else "") / f"{name}.yaml"


def fly(name: str) -> dict:
    """Fly a scenario, write its figure, and return what came of it."""
    from crazychoir_fw.flight import fly as fly_mission
    from crazychoir_fw.mission import load_mission
    from crazychoir_fw.recording.plot import plot_flight

    mission = load_mission(path_of(name))
    if mission.backend not in ("sim", "integrator"):
        mission = load_mission(path_of(name), backend="sim")
    result = fly_mission(mission, visuals=False)
    with tempfile.TemporaryDirectory() as folder:
        picture = Path(folder) / "flight.png"
        plot_flight(result.log, picture, mission.description or name, result.curve, result.timeline)
        shrink(picture, IMAGES / f"{name}.png")
    return {
        "sentence": mission.description,
        "backend": mission.backend,
        "drones": len(mission.fleet),
        "seconds": result.summary["sim_seconds"],
        "success": result.success,
        "failures": result.failures,
        "criteria": result.summary["criteria"],
    }


def shrink(source: Path, target: Path) -> None:
    """Write a picture with fewer pixels and colors, such that lines of different colors stay different."""
    from PIL import Image

    from crazychoir_fw.common.replacing import replacing

    picture = Image.open(source).convert("RGB")
    width = WIDTH
    while True:
        small = picture.resize((width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS)
        content = io.BytesIO()
        small = small.quantize(COLORS, Image.Quantize.MAXCOVERAGE, kmeans=1, dither=Image.Dither.NONE)
        small.save(content, "PNG", optimize=True)
        if content.tell() <= LARGEST or width < 400:
            break
        width = int(width * 0.85)
    target.parent.mkdir(parents=True, exist_ok=True)
    with replacing(target) as temporary:
        Path(temporary).write_bytes(content.getvalue())


def backend_option(name: str, result: dict) -> str:
    """Return what the command needs where the file's own backend is that of real drones."""
    from crazychoir_fw.mission import load_mission

    if "error" in result or load_mission(path_of(name)).backend == result["backend"]:
        return ""
    return f" --backend {result['backend']}"


def section(name: str, result: dict) -> str:
    """Return what the page says about a scenario."""
    file = os.path.relpath(path_of(name), PAGE.parent)
    path = path_of(name).relative_to(ROOT)
    lines = [f"## {name}", "", f"{result['sentence']}: [{path}]({file}).", ""]
    lines += ["```console", f"$ crazychoir fly {path}{backend_option(name, result)}", "```", ""]
    if "error" in result:
        return "\n".join([*lines, f"Not flown: {result['error']}", ""])
    drones = f"{result['drones']} drone{'s' if result['drones'] > 1 else ''}"
    flown = f"{drones}, {result['seconds']:.0f} s, backend {result['backend']}"
    lines += [f"{flown}: {'success' if result['success'] else 'failed: ' + '; '.join(result['failures'])}.", ""]
    if result["criteria"]:
        lines += ["| criterion | allowed | measured | |", "|---|---|---|---|"]
        for one in result["criteria"]:
            value = "not known" if one["value"] is None else f"{one['value']:g}"
            allowed = "yes" if one["limit"] is True else f"{one['limit']:g}"
            lines.append(f"| `{one['criterion']}` | {allowed} | {value} | {'passed' if one['passed'] else 'failed'} |")
        lines.append("")
    return "\n".join([*lines, f"![{result['sentence']}](images/gallery/{name}.png)", ""])


def main() -> int:
    """Fly, write the page, and return how many did not succeed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="scenarios; all without it")
    chosen = parser.parse_args().names or [*SCENARIOS, *BESIDES]
    if unknown := set(chosen) - {*SCENARIOS, *BESIDES}:
        parser.error(f"no such scenario: {', '.join(sorted(unknown))}; there are {', '.join((*SCENARIOS, *BESIDES))}")
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    for name in chosen:
        print(name, end=": ", flush=True)
        try:
            results[name] = fly(name)
        except Exception as error:  # the page says so, and the others are flown
            if not isinstance(error, OSError | ValueError):
                traceback.print_exc()
            text = str(error).replace(str(ROOT) + os.sep, "")
            results[name] = {"sentence": name, "error": text, "success": False}
        print("success" if results[name]["success"] else results[name].get("error") or results[name]["failures"])
    ordered = {name: results[name] for name in (*SCENARIOS, *BESIDES) if name in results}
    RESULTS.parent.mkdir(parents=True, exist_ok=True)
    RESULTS.write_text(json.dumps(ordered, indent=1) + "\n")
    PAGE.write_text(HEAD + "\n" + "\n".join(section(name, result) for name, result in ordered.items()))
    return sum(not result["success"] for result in ordered.values())


if __name__ == "__main__":
    raise SystemExit(main())
