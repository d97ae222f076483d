"""What the supervisor of a drone says about flying."""

from __future__ import annotations

import threading
import time
from collections.abc import Mapping

from cflib.crtp.crtpstack import CRTPPacket, CRTPPort

from crazychoir_fw.common.errors import RadioError, StateError
from crazychoir_fw.radio.crazyflie import LinkedCrazyflie
from crazychoir_fw.radio.parameters import ParameterValue, set_parameters

PROTOCOL_WITH_SUPERVISOR = 12

CAN_BE_ARMED = 1 << 0
IS_ARMED = 1 << 1
IS_AUTO_ARMED = 1 << 2
CAN_FLY = 1 << 3
IS_FLYING = 1 << 4
IS_TUMBLED = 1 << 5
IS_LOCKED = 1 << 6
IS_CRASHED = 1 << 7
IS_PLANNER_ACTIVE = 1 << 8
NEEDS_A_HAND = IS_TUMBLED | IS_LOCKED | IS_CRASHED
"""A person has to put it right."""

_ANSWER_S = 0.2
_NAP_S = 0.04  # as often as the supervisor looks
_ARM_AGAIN_S = 0.5
_INFO, _BIT_FIELD, _REPLY = 0, 0x0C, 0x80


def supervisor_bits(cf: LinkedCrazyflie) -> int | None:
    """Return the state of the supervisor, or None when it does not say; blocks up to 0.2 s.

    cflib's own reading repeats what it heard within the last 0.1 s, and takes silence for an answer.
    """
    if cf.platform.get_protocol_version() < PROTOCOL_WITH_SUPERVISOR:
        return None
    answers: list[int] = []
    answered = threading.Event()

    def heard(packet: CRTPPacket) -> None:
        data = bytes(packet.data)
        if len(data) >= 2 and data[0] == _REPLY | _BIT_FIELD:
            answers.append(int.from_bytes(data[1:], "little"))
            answered.set()

    request = CRTPPacket()
    request.set_header(CRTPPort.SUPERVISOR, _INFO)
    request.data = (_BIT_FIELD,)
    cf.add_header_callback(heard, CRTPPort.SUPERVISOR, _INFO)
    try:
        cf.send_packet(request)
        answered.wait(_ANSWER_S)
    finally:
        cf.remove_header_callback(heard, CRTPPort.SUPERVISOR, _INFO)
    return answers[0] if answers else None


def follows_planner(bits: int) -> bool | None:
    """Tell whether a drone flies what its planner says, by its supervisor; None when it cannot be known.

    A reset on the floor while motors begin to turn leaves it "flying" for 2 s with its motors off
    (docs/reference/planner-commander.md#14.2).
    """
    if not bits & IS_FLYING:
        return False
    return True if bits & IS_PLANNER_ACTIVE else None


def make_ready(cf: LinkedCrazyflie, who: str, *, arms: bool, timeout_s: float) -> bool:
    """Wait until the motors of a drone may run, and arm it if it must be armed.

    Args:
        cf: A connected drone.
        who: Name and URI, for errors.
        arms: Whether it may be armed.
        timeout_s: How long it may take (s).

    Returns:
        Whether it was armed here.

    Raises:
        StateError: If it does not become ready; the text says why.
        RadioError: If the link breaks meanwhile.
    """
    if cf.platform.get_protocol_version() < PROTOCOL_WITH_SUPERVISOR:
        return False  # older firmware arms itself, or refuses without a word
    began = time.monotonic()
    asked = None
    while True:
        bits = supervisor_bits(cf)
        if bits is not None and bits & CAN_FLY:
            return asked is not None
        if cf.link is None:
            raise RadioError(f"{who}: the link broke")
        now = time.monotonic()
        if (bits is not None and bits & IS_LOCKED) or now - began > timeout_s:
            raise StateError(f"{who}: the motors may not run: {why_grounded(bits, arms)}")
        must_be_armed = bits is not None and bits & CAN_BE_ARMED and not bits & (IS_ARMED | IS_AUTO_ARMED)
        if must_be_armed and arms and (asked is None or now - asked > _ARM_AGAIN_S):
            cf.supervisor.send_arming_request(True)
            asked = now
        time.sleep(_NAP_S)


def why_grounded(bits: int | None, arms: bool) -> str:
    """Return why a drone stays on the floor, by its supervisor: the rest of a sentence."""
    if bits is None:
        return "its supervisor does not answer"
    if bits & IS_LOCKED:
        return "it is locked, and must be restarted"
    if bits & IS_CRASHED:
        return "it has crashed; put it on its feet, and call recover()"
    if bits & IS_TUMBLED:
        return "it has tumbled"
    if not bits & IS_ARMED:
        return "it is not armed" if arms else "it is not armed, and this handler does not arm"
    return "its motors may run" if bits & CAN_FLY else "it is not ready"


_RESET = "kalman.resetEstimation"
_RESET_S = 0.1  # between both writes of a reset of the estimator


def set_up(
    cf: LinkedCrazyflie,
    who: str,
    presets: Mapping[str, ParameterValue],
    own: Mapping[str, ParameterValue],
    timeout_s: float,
    *,
    resets_estimator: bool,
) -> None:
    """Write parameters; a drone that flies is not disturbed beyond that.

    Args:
        cf: A connected drone.
        who: Name and URI, for errors.
        presets: Parameters that its set-points need, where this firmware has them.
        own: Parameters of the user, which win.
        timeout_s: How long one may take (s).
        resets_estimator: Whether the Kalman filter of a drone on the floor is reset.

    Raises:
        CrazychoirError: If there is no such parameter, a value does not fit, or the drone does not confirm.
    """
    bits = supervisor_bits(cf)
    is_flying = bits is not None and bool(bits & IS_FLYING)
    needed = {name: value for name, value in presets.items() if name not in own}
    set_parameters(cf, who, needed, timeout_s, optional=True)
    set_parameters(cf, who, own, timeout_s)
    if is_flying:
        return
    if resets_estimator:
        for value in (1, 0):
            set_parameters(cf, who, {_RESET: value}, timeout_s, optional=True)
            time.sleep(_RESET_S)
    # whatever program was connected before: its last set-point no longer keeps the planner from flying
    cf.commander.send_notify_setpoint_stop()
