"""The link of one drone through its life: connected, lost, called again, closed."""

from __future__ import annotations

import enum
import threading
from collections.abc import Callable
from pathlib import Path

from crazychoir_fw.common.errors import CrazychoirError, RadioError
from crazychoir_fw.radio.connection import Connection
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.options import Options
from crazychoir_fw.radio.threads import LOGGER


class LinkState(str, enum.Enum):
    """How a drone is connected."""

    DISCONNECTED = "disconnected"
    """Not yet, or given up."""
    CONNECTING = "connecting"
    CONNECTED = "connected"
    LOST = "lost"
    """The link broke; it waits before the next attempt."""
    RECONNECTING = "reconnecting"
    CLOSED = "closed"

    def __str__(self) -> str:
        return self.value


class DroneLink:
    """Keeps one drone connected, as far as the policy of reconnecting goes.

    Args:
        who: Name and URI, for errors.
        uri: Where the drone is.
        options: Time-outs, cache, policy.
        set_up: Called with a new connection, and whether it is the first one, before it counts as connected: writes
            parameters, starts logs.
        changed: Called with the new state and a reason, from whatever thread.
    """

    def __init__(
        self,
        who: str,
        uri: str,
        options: Options,
        set_up: Callable[[LinkedCrazyflie, bool], None],
        changed: Callable[[LinkState, str], None],
    ) -> None:
        self._who = who
        self._uri = uri
        self._options = options
        self._set_up = set_up
        self._changed = changed
        self._lock = threading.RLock()
        self._closing = threading.Event()
        self._connection: Connection | None = None
        self._opening: Connection | None = None
        self._caller: threading.Thread | None = None
        self.state = LinkState.DISCONNECTED
        self.reason = ""
        """Why it is in this state, where there is something to say."""
        self.losses = 0
        """How often the link broke."""

    @property
    def cf(self) -> LinkedCrazyflie | None:
        """Cflib's object, when the drone is connected; another one after each loss."""
        connection = self._connection
        return connection.cf if connection is not None and connection.is_open else None

    @property
    def is_connected(self) -> bool:
        """Whether packets reach the drone, as far as is known."""
        return self.state is LinkState.CONNECTED and self.cf is not None

    def connect(self, *, with_parameters: bool) -> None:
        """Connect, for the first time or again.

        Raises:
            RadioError: If the drone is not reached in time.
            CrazychoirError: If it cannot be set up as wanted; the link is closed then.
        """
        with self._lock:
            if self.state in (LinkState.CONNECTED, LinkState.CONNECTING, LinkState.LOST, LinkState.RECONNECTING):
                return
            self._closing.clear()
            self._set(LinkState.CONNECTING)
        self._with_parameters = with_parameters
        try:
            self._open(is_first=True)
        except BaseException as error:
            if not self._closing.is_set():
                self._set(LinkState.DISCONNECTED, str(error))
            raise

    def close(self) -> None:
        """Close the link for good; takes up to 1 s."""
        with self._lock:
            self._closing.set()
            opening = self._opening
        if opening is not None:
            opening.abandon()
        caller = self._caller
        if caller is not None and caller is not threading.current_thread():
            caller.join(self._options.connect_timeout_s)
        with self._lock:
            connection, self._connection = self._connection, None
            was_closed = self.state is LinkState.CLOSED
        if connection is not None:
            connection.close()
        if not was_closed:
            self._set(LinkState.CLOSED)

    def _open(self, *, is_first: bool) -> None:
        options = self._options
        connection = Connection(self._uri, _folder(options), self._lost)
        with self._lock:
            self._opening = connection
            if self._closing.is_set():
                connection.abandon()
        try:
            connection.open(options.answer_timeout_s, options.connect_timeout_s, with_parameters=self._with_parameters)
        except RadioError as error:
            raise RadioError(f"{self._who.removesuffix(f' ({self._uri})')}: {error}") from None
        finally:
            self._opening = None
        try:
            self._set_up(connection.cf, is_first)
        except BaseException:
            connection.close()
            raise
        with self._lock:
            if self._closing.is_set():
                gone = True
            else:
                gone = not connection.is_open
                self._connection = connection
                if not gone:
                    self._set(LinkState.CONNECTED)
        if gone:
            connection.close()
            raise RadioError(f"{self._who}: the link broke while the drone was set up")

    def _lost(self, connection: Connection, reason: str) -> None:
        with self._lock:
            if connection is not self._connection or self._closing.is_set():
                return  # while it is set up, `_open` finds out
            self._connection = None
            self.losses += 1
            self._set(LinkState.LOST, reason)
            self._caller = threading.Thread(
                target=self._call_again, args=(connection, reason), name=f"radio-reconnect-{self._uri}", daemon=True
            )
            self._caller.start()

    def _call_again(self, old: Connection, reason: str) -> None:
        old.close()
        policy = self._options.reconnect
        attempts = 0
        for wait in policy.waits() if policy is not None else ():
            if self._closing.wait(wait):
                return
            attempts += 1
            self._set(LinkState.RECONNECTING, f"attempt {attempts}")
            try:
                self._open(is_first=False)
                return
            except CrazychoirError as error:
                reason = str(error)
            except Exception as error:  # of cflib, for instance, when the link breaks again while it is at work
                LOGGER.exception("%s: attempt %d failed", self._who, attempts)
                reason = repr(error)
            if self._closing.is_set():
                return
            self._set(LinkState.LOST, reason)
        tried = f"given up after {attempts} attempts: " if attempts else ""
        self._set(LinkState.DISCONNECTED, tried + reason)

    def _set(self, state: LinkState, reason: str = "") -> None:
        self.state, self.reason = state, reason
        self._changed(state, reason)


def _folder(options: Options) -> Path | None:
    return Path(options.cache) if options.cache is not None else None
