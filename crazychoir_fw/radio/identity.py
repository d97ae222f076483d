"""Which drone answers: a real one, or one of a served simulation, which says its name; and its firmware."""

from __future__ import annotations

import threading

from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

from crazychoir_fw.radio.crazyflie import LinkedCrazyflie

SIMULATION_LOGS = "sim"
"""Group of log variables that simulated drones have and real ones do not: the truth."""
ASK_NAME = 0x53
"""Question on the version channel of the platform port, answered by served simulations only."""

_VERSION = 1
_FIRMWARE = 1
_ANSWER_S = 2.0


def simulated_name(cf: LinkedCrazyflie) -> str | None:
    """Return the name of a simulated drone, None for a real one; blocks until the drone has said it.

    A simulation that does not say names is called ``?``.
    """
    toc = cf.log.toc
    if toc is None or SIMULATION_LOGS not in toc.toc:
        return None
    return _ask(cf, ASK_NAME) or "?"


def firmware_of(cf: LinkedCrazyflie) -> str | None:
    """Return what a drone calls its firmware, such as ``2026.08``; None when it does not say within 2 s."""
    return _ask(cf, _FIRMWARE)


def _ask(cf: LinkedCrazyflie, question: int) -> str | None:
    """Return the answer to a question on the version channel, None without one."""
    answers: list[str] = []
    answered = threading.Event()

    def heard(packet: CRTPPacket) -> None:
        data = bytes(packet.data)
        if len(data) > 1 and data[0] == question:
            answers.append(data[1:].decode("utf-8", "replace").rstrip("\0"))
            answered.set()

    request = CRTPPacket()
    request.set_header(CRTPPort.PLATFORM, _VERSION)
    request.data = (question,)
    cf.add_header_callback(heard, CRTPPort.PLATFORM, _VERSION)
    try:
        cf.send_packet(request)
        answered.wait(_ANSWER_S)
    finally:
        cf.remove_header_callback(heard, CRTPPort.PLATFORM, _VERSION)
    return answers[0] if answers else None
