"""The past of a flight, as browsers are told it."""

import json

import numpy as np

from crazychoir_fw.gui.branches import Branches, Sample


def test_who_was_not_heard_of_is_nowhere():
    branches = Branches()
    unknown = np.full((2, 3), np.nan, np.float32)
    for time, place in ((0.0, np.nan), (0.1, 0.5)):
        position = np.array([[place, place, place], [1.0, 2.0, 0.25]], np.float32)
        sample = Sample(position, np.zeros((2, 4), np.float32), unknown, unknown, None)
        branches.present.sample(time, sample)
    path = json.loads(json.dumps(branches.path(0), allow_nan=False))
    assert path["positions"] == [[None, [1.0, 2.0, 0.25]], [[0.5, 0.5, 0.5], [1.0, 2.0, 0.25]]]
    assert path["times"] == [0.0, 0.1]
