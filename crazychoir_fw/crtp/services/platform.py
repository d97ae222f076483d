"""Port 13, the platform service: versions, old requests, and the app channel (docs/reference/crtp-cflib.md#6)."""

from __future__ import annotations

import struct
from collections.abc import Iterable

from crazychoir_fw._core import lib
from crazychoir_fw.common.errors import CrazychoirError
from crazychoir_fw.crtp.packet import MAX_PAYLOAD, Port
from crazychoir_fw.crtp.service_context import ServiceContext
from crazychoir_fw.crtp.services.app_channel import CHANNEL as APP
from crazychoir_fw.crtp.services.app_channel import AppChannel
from crazychoir_fw.crtp.services.service import Reply
from crazychoir_fw.onboard.core import provider_identity

COMMAND, VERSION = 0, 1
"""Channels beside that of apps."""

CONTINUOUS_WAVE, ARM, RECOVER, NOTIFY = range(4)
"""Requests on the command channel. Clients of protocol version 12 arm and recover on port 9."""

GET_PROTOCOL, GET_FIRMWARE, GET_DEVICE = range(3)
"""Requests on the version channel."""

PROTOCOL_VERSION = 12
FIRMWARE_RELEASE = "2026.08"
"""The release that the built-in provider follows."""

DEVICE_TYPES = {"cf2": "CF21", "cf21bl": "CF21BL"}
"""What the platforms call themselves. ``cf2`` has the propellers of the 2.1+, so it is no CF20."""


class PlatformService:
    """Who this drone is. Its app channel is at `app_channel`."""

    ports = (Port.PLATFORM,)

    def __init__(self, context: ServiceContext) -> None:
        self._context = context
        self.app_channel = AppChannel(context)
        platform = context.drone.config.platform
        texts = {
            GET_FIRMWARE: firmware_version(context.drone.provider_number),
            GET_DEVICE: DEVICE_TYPES.get(platform, platform),
        }
        self._versions = {GET_PROTOCOL: struct.pack("<Bi", GET_PROTOCOL, PROTOCOL_VERSION)}
        for request, text in texts.items():
            self._versions[request] = bytes((request,)) + text.encode("ascii", "replace")[: MAX_PAYLOAD - 1]

    def receive(self, port: int, channel: int, payload: bytes) -> Iterable[Reply]:
        """Answer a question, let a request take effect, or hand a message to whoever plays the app."""
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
        return ((COMMAND, payload),)  # a continuous wave disturbs nobody here

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
