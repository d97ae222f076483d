"""Regressions that were planted in an app: a campaign before and after says NO-GO, and names what brings them out."""

import pytest
import yaml

from crazychoir_fw.campaign.campaign import load_campaign
from crazychoir_fw.campaign.compare import compare, culprits, variants_of
from crazychoir_fw.campaign.engines import here
from crazychoir_fw.campaign.run import run

ESTIMATOR = """
#include "estimator.h"
#include "math3d.h"

#define TIMEOUT_MS {timeout_ms}  // without a pose: then it gives up, and keeps what it has
#define KEPT_PER_GAP {kept_per_gap}f  // [m], of the prediction over a lost pose that no update takes back

static point_t   position;
static velocity_t velocity;
static float     kept;
static uint32_t  latest, started;
static bool      has_pose, gave_up;

void estimatorOutOfTreeInit(void) {{
  kept = 0.0f;
  has_pose = gave_up = false;
}}

bool estimatorOutOfTreeTest(void) {{ return true; }}

static void follow(state_t *state, const poseMeasurement_t *pose, uint32_t now) {{
  const uint32_t gap = now - latest;
  if (has_pose && gap > 0) {{
    const float rate = 1000.0f / gap, old = 0.7f, newest = 0.3f;
    velocity.x = old * velocity.x + newest * rate * (pose->x + kept - position.x);
    velocity.y = old * velocity.y + newest * rate * (pose->y - position.y);
    velocity.z = old * velocity.z + newest * rate * (pose->z - position.z);
  }}
  if (has_pose && gap > 15 && now > 1500) kept += KEPT_PER_GAP;
  position = (point_t){{.x = pose->x + kept, .y = pose->y, .z = pose->z}};
  latest = now;
  has_pose = true;
  const quaternion_t *q = &pose->quat;
  const struct vec rpy = quat2rpy(mkquat(q->x, q->y, q->z, q->w));
  state->attitudeQuaternion = *q;
  state->attitude = (attitude_t){{.roll = degrees(rpy.x), .pitch = -degrees(rpy.y), .yaw = degrees(rpy.z)}};
}}

void estimatorOutOfTree(state_t *state, const stabilizerStep_t now) {{
  measurement_t measurement;
  if (has_pose && now > 1500 && now - latest > TIMEOUT_MS) gave_up = true;
  while (estimatorDequeue(&measurement)) {{
    if (measurement.type == MeasurementTypePose && !gave_up) follow(state, &measurement.data.pose, now);
  }}
  state->position = position;
  state->velocity = velocity;
}}
"""

GOOD = {"timeout_ms": 400, "kept_per_gap": "0.0"}
DECOYS = {
    "defaults.battery": {"uniform": [0.8, 1.0]},
    "defaults.mass": {"normal": {"mean": 0.029, "std": 0.0005}},
}
MISSION = {
    "name": "stand",
    "drones": [{"id": "cf1", "position": [0.0, 0.0]}],
    "flight": [
        {"takeoff": {"height": 0.6, "duration": 1.5}},
        {"hover": {"duration": 6.0}},
        {"land": {"duration": 1.5}},
    ],
}


@pytest.fixture
def before_and_after(tmp_path):
    """Flies the estimator as it should be, and with something changed; returns the comparison."""

    def fly(fault, vary, **changed):
        for name, chosen in (("before", GOOD), ("after", {**GOOD, **changed})):
            (tmp_path / f"{name}.c").write_text(ESTIMATOR.format(**chosen))
        (tmp_path / "stand.yaml").write_text(yaml.safe_dump({**MISSION, "faults": [fault]}))
        campaign = {
            "extends": "stand.yaml",
            "flights": 24,
            "vary": {**vary, **DECOYS},
            "require": {"success": 0.8, "confidence": 0.85},
            "compare": {name: {"app": [f"{name}.c"]} for name in ("before", "after")},
        }
        path = tmp_path / "campaign.yaml"
        path.write_text(yaml.safe_dump(campaign, sort_keys=False))
        sides = variants_of(load_campaign(path))
        return compare(*(run(side, tmp_path / name, here) for name, side in sides.items()))

    return fly


def assert_found(both, key):
    assert both.before.verdict.answer == "GO", both.before.verdict.reasons
    assert both.answer == "NO-GO"
    assert len(both.broken) > 4 and not both.mended
    named = culprits(both)
    assert named[0].key == key
    assert abs(named[0].rank) > 0.5


def test_a_time_out_that_is_too_short_is_found(before_and_after):
    key = "faults[0].positioning.duration"
    fault = {"positioning": {"at": 3.0, "lost": True, "duration": 0.1}}
    assert_found(before_and_after(fault, {key: {"uniform": [0.02, 0.2]}}, timeout_ms=130), key)


def test_an_estimator_that_diverges_with_three_percent_of_drop_outs_is_found(before_and_after):
    key = "faults[0].radio.loss"
    fault = {"radio": {"at": 2.0, "loss": 0.01, "duration": 5.0}}
    assert_found(before_and_after(fault, {key: {"uniform": [0.0, 0.03]}}, kept_per_gap="0.03"), key)
