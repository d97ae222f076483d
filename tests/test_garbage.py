import gc

import pytest

from crazychoir_fw.common.garbage import present_objects_frozen


@pytest.fixture(autouse=True)
def nothing_frozen():
    gc.unfreeze()
    yield
    gc.freeze()  # as conftest.py does for the whole session


def test_objects_are_frozen_meanwhile():
    with present_objects_frozen():
        assert gc.get_freeze_count() > 0
    assert gc.get_freeze_count() == 0


def test_they_thaw_after_an_error():
    with pytest.raises(KeyError), present_objects_frozen():
        raise KeyError
    assert gc.get_freeze_count() == 0


def test_what_another_component_froze_stays_frozen():
    gc.freeze()
    with present_objects_frozen():
        pass
    assert gc.get_freeze_count() > 0
