"""What a campaign says of a mission today: its verdict, as long as mission, values and build are those that it flew."""

from __future__ import annotations

import json
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crazychoir_fw.campaign.campaign import load_campaign
from crazychoir_fw.campaign.compare import variants_of
from crazychoir_fw.campaign.identity import identity_of
from crazychoir_fw.campaign.verdict import GO
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.preflight.check import Check

NAME = "campaign"
_NEEDED = {"file": str, "mission": str, "identity": str, "answer": str, "reasons": list, "seed": int, "design": str}


def standing(mission: Path, changes: Sequence[str], folder: Path) -> Check:
    """Return the verdict of the campaign in a folder, which is good if it is GO and of exactly this mission.

    Args:
        mission: The mission file.
        changes: Its changes, as `--set` takes them.
        folder: Results of a campaign.
    """
    path = folder / "summary.json"
    if not path.is_file():
        return Check(NAME, False, f"none was flown: {path} is not there; run crazychoir campaign {mission}")
    summary = _read(path)
    if summary is None:
        return Check(NAME, False, f"{path} is no summary of a campaign of this version; fly it again")
    if Path(summary["mission"]).resolve() != mission.resolve():
        return Check(NAME, False, f"that in {folder} flew {summary['mission']}, and not {mission}")
    try:
        campaign = load_campaign(Path(summary["file"]), changes, seed=summary["seed"], design=summary["design"])
        if campaign.settings.compare is not None:  # results of either side
            campaign = variants_of(campaign).get(folder.name, campaign)
        is_same = identity_of(campaign) == summary["identity"]
    except (CrazychoirError, OSError) as error:
        return Check(NAME, False, f"that in {folder} cannot be compared: {error}")
    if not is_same:
        again = shlex.join(["crazychoir", "campaign", summary["file"], "--anew", *(f"--set={one}" for one in changes)])
        return Check(NAME, False, f"stale: mission, values or build were changed since; run {again}")
    reasons = "; ".join(map(str, summary["reasons"]))
    return Check(NAME, summary["answer"] == GO, f"{summary['answer']}: {reasons}")


def _read(path: Path) -> dict[str, Any] | None:
    try:
        summary = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None
    if not isinstance(summary, dict) or not all(isinstance(summary.get(key), kind) for key, kind in _NEEDED.items()):
        return None
    return summary
