"""The module over each provider; the checkouts are miniatures, laid out and compiled once per session."""

import os
from pathlib import Path

import pytest
from miniature import lay_out

from crazychoir_fw import cffirmware

OLDEST = "2024.10"


def _spoil(checkout):
    """Let one of its functions fail an assertion."""
    source = checkout / "src/modules/src/kalman_core/kalman_core.c"
    text = source.read_text().replace("kalmanCoreDecoupleXY(", "kalmanCoreDecoupleXYBefore(")
    failing = 'void kalmanCoreDecoupleXY(kalmanCoreData_t *c) { (void)c; assertFail("P < 0", "kalman_core.c", 12); }'
    source.write_text(f"{text}\nvoid assertFail(char *exp, char *file, int line);\n{failing}\n")


@pytest.fixture(scope="session")
def shared_folder(tmp_path_factory):
    """A folder that all workers of a session have in common."""
    own = tmp_path_factory.getbasetemp()
    folder = own.parent if "PYTEST_XDIST_WORKER" in os.environ else own
    shared = folder / "cffirmware"
    shared.mkdir(exist_ok=True)
    return shared


@pytest.fixture(scope="session")
def checkout(shared_folder):
    """Return a function that lays a release of the miniature out, once.

    CRAZYCHOIR_TEST_CHECKOUT names a checkout of the real firmware to take for the newest release.
    """

    def laid_out(release):
        if release != OLDEST and "CRAZYCHOIR_TEST_CHECKOUT" in os.environ:
            return Path(os.environ["CRAZYCHOIR_TEST_CHECKOUT"])
        target = shared_folder / f"checkout {release}"
        if not target.exists():
            scratch = shared_folder / f"scratch-{release}-{os.getpid()}"
            lay_out(scratch, release=release)
            if release == OLDEST:
                _spoil(scratch)
            try:
                scratch.rename(target)
            except OSError:
                assert target.exists()  # another worker was faster
        return target

    return laid_out


@pytest.fixture(scope="session")
def over_miniature(shared_folder, checkout):
    """Return a function that makes the module over a release of the miniature."""

    def module(release):
        before = os.environ.get("CRAZYCHOIR_CACHE")
        os.environ["CRAZYCHOIR_CACHE"] = str(shared_folder / "cache")
        try:
            return cffirmware.over("bitcraze", checkout=checkout(release))
        finally:
            os.environ.pop("CRAZYCHOIR_CACHE")
            if before is not None:
                os.environ["CRAZYCHOIR_CACHE"] = before

    return module


@pytest.fixture(scope="session")
def modules(over_miniature):
    return {"builtin": lambda: cffirmware.over("builtin"), "bitcraze": lambda: over_miniature("2026.08")}


@pytest.fixture(params=["builtin", "bitcraze"])
def firm(request, modules):
    """The module over each provider."""
    return modules[request.param]()


@pytest.fixture
def fresh(firm):
    """The same, with controllers that remember nothing yet."""
    return firm.instance()


@pytest.fixture(scope="session")
def old_firm(over_miniature):
    """The module over the oldest supported release."""
    return over_miniature(OLDEST)
