"""Port 13, the platform service: versions, old requests, and the app channel (docs/reference/crtp-cflib.md#6)."""

from __future__ import annotations

import struct
import threading
from collections import deque
from collections.abc import Callable, Iterable

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import CrazychoirError, RangeError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.onboard.core import provider_identity

COMMAND, VERSION = 0, 1
"""Channels beside that of apps."""

CONTINUOUS_WAVE, ARM, RECOVER, NOTIFY = range(4)
"""Requests on the command channel. Clients of protocol version 12 arm and recover on port 9."""

GET_PROTOCOL, GET_FIRMWARE, GET_DEVICE = range(3)
"""Requests on the version channel."""

GET_NAME = 0x53
"""Request on the version channel that no Crazyflie knows: the answer is the name of a simulated drone, so that a client
which means a real one, or another simulation, notices (`crazychoir_fw.radio.identity`)."""

PROTOCOL_VERSION = 12
FIRMWARE_RELEASE = "2026.08"
"""The release that the built-in provider follows."""

DEVICE_TYPES = {"cf2": "CF21", "cf21bl": "CF21BL"}
"""What the platforms call themselves. ``cf2`` has the propellers of the 2.1+, so it is no CF20."""


class PlatformService:
    """Platform and firmware version of this drone. Its app channel is at `app_channel`."""

    ports = (Port.PLATFORM,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self.app_channel = AppChannel(context)
        platform = context.drone.config.platform
        texts = {
            GET_FIRMWARE: firmware_version(context.drone.provider_number),
            GET_DEVICE: DEVICE_TYPES.get(platform, platform),
            GET_NAME: context.drone.id,
        }
        self._versions = {GET_PROTOCOL: struct.pack("<Bi", GET_PROTOCOL, PROTOCOL_VERSION)}
        for request, text in texts.items():
            self._versions[request] = bytes((request,)) + text.encode()[: MAX_PAYLOAD - 1]

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer a question, let a request take effect, or hand a message to the app."""
        if not payload:
            return ()
        if channel == COMMAND:
            return self._command(payload)
        if channel == VERSION:
            # what is not known comes back, as on the command channel
            return ((VERSION, self._versions.get(payload[0], payload)),)
        if channel == APP:
            self.app_channel.take(payload)
        return ()

    def end_session(self) -> None:
        """Keep what the app has not fetched: apps do not know of sessions."""

    def _command(self, payload: bytes) -> Iterable[Reply]:
        command = payload[0]
        if command == ARM:
            if len(payload) < 2:
                return ((COMMAND, bytes((ARM, False))),)
            return self._request(ARM, "cf_arm", payload[1] != 0)
        if command == RECOVER:
            return self._request(RECOVER, "cf_recover_from_crash")
        if command == NOTIFY:
            return ((COMMAND, b""),)
        return ((COMMAND, payload),)  # a continuous wave disturbs nothing here

    def _request(self, command: int, verb: str, *arguments: bool) -> Iterable[Reply]:
        """Let a request take effect; the reply, which says whether it did, comes then."""

        def carry_out() -> None:
            try:
                is_granted = self._context.drone.uplink.request(verb, *arguments) == lib.CF_OK
            except CrazychoirError:
                is_granted = False
            self._context.send(Port.PLATFORM, COMMAND, bytes((command, is_granted)))

        return () if self._context.later(carry_out) else ((COMMAND, bytes((command, False))),)


def firmware_version(provider: int) -> str:
    """Return what drones with this provider call their firmware: a release, and what it really is."""
    identity = provider_identity(provider)
    version = identity.get("version", "unknown")
    return f"{FIRMWARE_RELEASE} +crazychoir {version}" if provider == 0 else str(version)


APP = 2
MAX_MESSAGES = 100
"""Messages of the client that wait for the simulation; more are lost."""


class AppChannel:
    """The drone's end of the channel, for Python that stands in for an app on board.

    Messages wait in `received` until `receive` fetches them. With a `callback` they do not wait: it is called with each
    of them by the simulation thread between two steps, so that it may do to the drone whatever it likes.
    """

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self._lock = threading.Lock()
        self.received: deque[bytes] = deque()
        """What the client has sent and is not fetched yet, oldest first."""
        self.lost = 0
        """How many messages came while too many waited."""
        self.callback: Callable[[bytes], None] | None = None
        """Called with every message, instead of letting it wait."""
        self._is_called = False  # the simulation will look

    def send(self, data: bytes) -> None:
        """Send a message to the client, if there is one; cflib hands it to `appchannel.packet_received`.

        Raises:
            RangeError: If it is empty or longer than 30 bytes.
        """
        if not 1 <= len(data) <= MAX_PAYLOAD:
            raise RangeError(f"{self._context.drone.id}: app channel: {len(data)} bytes, allowed: 1 to {MAX_PAYLOAD}")
        self._context.send(Port.PLATFORM, APP, bytes(data))

    def receive(self) -> bytes | None:
        """Return the oldest message that waits, or None. Any thread may call this."""
        with self._lock:
            return self.received.popleft() if self.received else None

    def take(self, data: bytes) -> None:
        """Take a message of the client; the radio thread calls this."""
        with self._lock:
            if len(self.received) >= MAX_MESSAGES:
                self.lost += 1
                return
            self.received.append(data)
        if self.callback is not None:
            self._call_soon()

    def _call_soon(self) -> None:
        with self._lock:
            if self._is_called or not self.received:
                return
            self._is_called = True
        self._context.later(self._call_back, is_bounded=True)

    def _call_back(self) -> None:
        with self._lock:
            self._is_called = False
        try:
            while self.callback is not None and (data := self.receive()) is not None:
                self.callback(data)
        except BaseException:
            self._call_soon()  # the others do not wait for the next message
            raise
