"""DISROPT's own problems, agents and algorithms over a communicator of ours, without MPI.

Parts of DISROPT import MPI though they do not need it. `import_disropt` gives the package either way; `adapted` makes
a communicator that its agents accept of one of `crazychoir_fw.guidance`.
"""

from __future__ import annotations

import importlib
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.errors import MissingLibraryError, StateError

if TYPE_CHECKING:
    from crazychoir_fw.guidance.communicator import TopicCommunicator

_PARTS = ("communicators", "agents", "functions", "problems", "algorithms", "utils.graph_constructor")


class _NoMPI(ModuleType):
    """Stands for `mpi4py.MPI`: it can be imported, and says what to do when it is asked for anything."""

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        raise StateError(
            "there is no MPI here: give the agent a communicator with disropt_bridge.adapted(communicator)"
        )


@contextmanager
def without_mpi() -> Iterator[None]:
    """Let `import disropt...` work inside of this block, whether MPI is there or not.

    Where the real `mpi4py.MPI` loads, nothing is changed. Where it does not, a stand-in takes its place for the block
    only.
    """
    if _loads_mpi():
        yield
        return
    before = {name: sys.modules.get(name) for name in ("mpi4py", "mpi4py.MPI")}
    package = before["mpi4py"] or ModuleType("mpi4py")
    stand_in = _NoMPI("mpi4py.MPI")
    had = vars(package).get("MPI")
    package.MPI = stand_in  # type: ignore[attr-defined]
    sys.modules["mpi4py"], sys.modules["mpi4py.MPI"] = package, stand_in
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
        if had is None:
            del package.MPI
        else:
            package.MPI = had  # type: ignore[attr-defined]


def _loads_mpi() -> bool:
    try:
        importlib.import_module("mpi4py.MPI")
    except (ImportError, RuntimeError):  # not installed, or no MPI library on this machine
        return False
    return True


def import_disropt() -> ModuleType:
    """Return the package DISROPT with all of its parts loaded.

    Raises:
        MissingLibraryError: If it is not installed.
    """
    try:
        with without_mpi():
            package = importlib.import_module("disropt")
            for part in _PARTS:
                importlib.import_module(f"disropt.{part}")
    except ModuleNotFoundError as error:
        raise MissingLibraryError(
            f"DISROPT cannot be used, {error.name} is missing: run pip install 'crazychoir-fw[disropt]'"
        ) from error
    return package


def adapted(communicator: TopicCommunicator, timeout: float | None = None) -> Any:
    """Return a communicator that DISROPT's agents accept, over a `TopicCommunicator`.

    DISROPT's algorithms cannot go on without a neighbor: after the timeout of a round the run ends with an error,
    instead of waiting indefinitely. The algorithms may change objects that they receive.

    Args:
        communicator: The one to use. Algorithms that send something else to each neighbor (ADMM, dual decomposition)
            need differentiated topics; asynchronous algorithms need `synchronous_mode=False`.
        timeout: How long to wait for neighbors in a round (s); None is the deadline of the communicator.

    Raises:
        MissingLibraryError: If DISROPT is not installed.
    """
    base = import_disropt().communicators.Communicator

    class AdaptedCommunicator(base):  # type: ignore[misc, valid-type]
        """A communicator of ours with DISROPT's interface."""

        def __init__(self) -> None:
            super().__init__()
            self.rank = communicator.rank
            self.size = communicator.size

        def neighbors_send(self, obj: Any, neighbors: Sequence[int]) -> None:
            communicator.neighbors_send(obj, neighbors)

        def neighbors_receive(
            self, neighbors: Sequence[int], stop_event: threading.Event | None = None
        ) -> dict[int, Any]:
            received = communicator.neighbors_receive(neighbors, stop_event=stop_event, timeout=timeout)
            return self._whole(received, neighbors, stop_event)

        def neighbors_receive_asynchronous(self, neighbors: Sequence[int]) -> dict[int, Any]:
            return _own(communicator.neighbors_receive_asynchronous(neighbors))

        def neighbors_exchange(
            self,
            send_obj: Any,
            in_neighbors: Sequence[int],
            out_neighbors: Sequence[int],
            dict_neigh: bool = False,
            stop_event: threading.Event | None = None,
        ) -> dict[int, Any]:
            received = communicator.neighbors_exchange(
                send_obj, in_neighbors, out_neighbors, dict_neigh, stop_event=stop_event, timeout=timeout
            )
            return self._whole(received, in_neighbors, stop_event)

        def _whole(
            self, received: Mapping[int, Any], neighbors: Sequence[int], stop_event: threading.Event | None
        ) -> dict[int, Any]:
            silent = [one for one in neighbors if one not in received]
            if silent and not (stop_event is not None and stop_event.is_set()):
                names = ", ".join(map(str, silent))
                raise StateError(f"agent {self.rank}: no message of agent {names} in time, and DISROPT needs all")
            return _own(received)

    return AdaptedCommunicator()


def _own(obj: Any) -> Any:
    """Return a copy whose arrays may be written to."""
    if isinstance(obj, np.ndarray):
        return obj.copy()
    if isinstance(obj, dict):
        return {key: _own(item) for key, item in obj.items()}
    if isinstance(obj, list | tuple):
        return type(obj)(_own(item) for item in obj)
    return obj
