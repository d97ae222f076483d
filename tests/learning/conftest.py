import pytest

from crazychoir_fw.simulation import set_threads


@pytest.fixture(autouse=True)
def one_thread():
    set_threads(1)
    yield
    set_threads(1)
