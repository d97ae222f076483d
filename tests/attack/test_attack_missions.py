"""Spoilt missions on the command line. `ATTACK_MISSIONS=100000` tries so many."""

import os
import time
from pathlib import Path

import pytest
import yaml
from command_line import Campaign, hostile_folder, limited, try_mission
from mutants import Mutator, seeds

COUNT = int(os.environ.get("ATTACK_MISSIONS", "300"))
SEED = int(os.environ.get("ATTACK_SEED", "1"))


@pytest.mark.timeout(300 + COUNT // 20)
def test_spoilt_missions_are_refused_in_one_sentence_each(tmp_path):
    missions = seeds()
    assert len(missions) > 20
    mutator, campaign = Mutator(missions, SEED), Campaign()
    began = time.perf_counter()
    with hostile_folder(tmp_path), limited():
        for name, mission in missions.items():
            try_mission(campaign, tmp_path / Path(name).parent / "mutant.yaml", yaml.safe_dump(mission).encode())
        print(f"{len(missions)} missions as they are: {dict(campaign.outcomes)}")
        for number in range(COUNT):
            options = ["--set", mutator.change()] if number % 20 == 0 else []
            folder, content = mutator.mutant()
            try_mission(campaign, tmp_path / folder / "mutant.yaml", content, *options)
            if number % 10_000 == 9_999:
                print(f"{number + 1} missions: {dict(campaign.outcomes)}", flush=True)
            if len(campaign.failures) >= int(os.environ.get("ATTACK_FAILURES", "5")):
                break
    print(f"{COUNT} missions in {time.perf_counter() - began:.0f} s: {dict(campaign.outcomes)}")
    assert not campaign.failures, "\n\n".join(campaign.failures)
    assert campaign.outcomes["refused"] > COUNT // 2
