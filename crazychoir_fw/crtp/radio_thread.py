"""The radio thread: brings datagrams to stations and their replies back, and never waits for the simulation."""

from __future__ import annotations

import logging
import selectors
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from typing import Any

from crazychoir_fw.crtp.client_session import Address, Ruling, is_link_source
from crazychoir_fw.crtp.drone_radio import DroneRadio, TokenBucket
from crazychoir_fw.crtp.link_model import Direction, Link
from crazychoir_fw.crtp.pacing import Clock
from crazychoir_fw.crtp.packet import NULL
from crazychoir_fw.crtp.power_switch import Power, is_power_request
from crazychoir_fw.crtp.read_scheduler import ReadScheduler
from crazychoir_fw.crtp.sockets import LONGEST, is_for_one_address, open_private, read_refusals, receive, turn_to
from crazychoir_fw.crtp.toc import parameter_toc

_MAX_DATAGRAMS = 64
"""Read of one socket in a row, so that one drone's flood does not keep others waiting."""
_MAX_LOOKS = 4096
"""At all sockets in one turn, so that a flood does not stop a simulation in lockstep."""
_MAX_WAITING = 4096
"""Read of a socket when its client gets one of its own: more datagrams than its buffer holds."""
_SETTLES_S = 0.2
"""So long after that (s) the shared socket is read first: a datagram may have been on its way to it."""
_MAX_UNSENT = 2000
_ASKED_IN_TURN = (2, 5)  # ports of parameters and logs
_MAX_REPORTS = 50
STALL_SHARE = 0.5
"""A client that has been silent for half the time that ends a session, without a ping even, does not read either: it
gets replies, but no log data."""
_LOOK_S = 0.02
"""Interval between two checks for disconnected clients (s)."""
_DEAF_S = 0.1
"""After a pause of the thread longer than this (s), it reads the sockets before it ends sessions for silence."""
_IDLE_S = 0.5
_RETRY_S = 0.001

logger = logging.getLogger("crazychoir_fw.crtp")


class _Letter(bytes):
    """A datagram on its way through a link, which may take longer than its client stays."""

    client: Address | None
    session: int

    @classmethod
    def of(cls, radio: DroneRadio, datagram: bytes) -> _Letter:
        letter = cls(datagram)
        letter.client, letter.session = radio.session.address, radio.counts.sessions
        return letter


class Radio:
    """All radios of a server and the thread that serves them.

    A turn may also be taken by the simulation thread, in lockstep; a lock keeps the two apart.
    """

    def __init__(
        self, radios: Sequence[DroneRadio], link: Link | None, clock: Clock, link_clock: Clock, silence_s: float
    ) -> None:
        """Get ready.

        Args:
            radios: Those of all drones.
            link: What the packets go through; None is a perfect one, at no cost.
            clock: Time by which clients are silent and packets are too many.
            link_clock: Time of the link.
            silence_s: So long (s) a drone hears nothing until a session is over.
        """
        self._radios = radios
        self._by_name = {radio.name: radio for radio in radios}
        self._link = link
        self._clock = clock
        self._link_clock = link_clock
        self.link_rate: float = 0.0
        """Seconds of the link's clock per second on the wall; 0 while the simulation drives it, and takes turns."""
        self._silence_s = silence_s
        self.when_a_session_ended: Callable[[], None] = lambda: None
        self._lock = threading.Lock()
        self._selector = selectors.DefaultSelector()
        for radio in radios:
            self._selector.register(radio.socket, selectors.EVENT_READ, radio)
            radio.station.context.wake_radio = partial(self._wake_for, radio)
        self._wake_in, self._wake_out = socket.socketpair()
        self._wake_in.setblocking(False)
        self._wake_out.setblocking(False)
        self._selector.register(self._wake_out, selectors.EVENT_READ, None)
        self._is_awake = False  # the thread was woken, and has not looked yet
        self._is_closing = False
        self._with_output: deque[DroneRadio] = deque()  # some of them perhaps twice
        self._next_look = self._latest_turn = self._settled_at = 0.0
        self._was_deaf = False
        self._rest_s = _IDLE_S  # between two looks, so that no packet has to wait for a look at every drone
        values = max((len(parameter_toc(radio.station.context.drone.provider_number)) for radio in radios), default=0)
        self._turns: ReadScheduler[DroneRadio] = ReadScheduler(values)
        self._reported: set[tuple[str, str]] = set()
        self._thread = threading.Thread(target=self._run, name="crazychoir radio", daemon=True)

    def start(self) -> None:
        """Begin to serve."""
        self._thread.start()

    def close(self) -> None:
        """End the thread, all sessions, and close the sockets."""
        self._is_closing = True
        self.wake()
        if self._thread.ident is not None:
            self._thread.join()
        now = self._clock()
        for radio in self._radios:
            self._end(radio, now, "closed")
            radio.session.leave()
            radio.station.context.wake_radio = lambda: None
            if radio.private is not None:
                radio.private.close()
                radio.private = radio.private_for = None
            radio.socket.close()
        self._selector.close()
        self._wake_in.close()
        self._wake_out.close()

    def wake(self) -> None:
        """Have the thread look around; any thread may ask."""
        if not self._is_awake:
            self._is_awake = True
            # a full pipe wakes as well
            with suppress(OSError):
                self._wake_in.send(b"\0")

    def turn(self, advance: Callable[[], None]) -> None:
        """Take what has come, let the clocks advance, and do what is due then, all in the thread of the caller.

        Whether the radio thread or this one takes a packet, it has come before the clocks advanced.
        """
        with self._lock:
            for _ in range(_MAX_LOOKS):
                events = self._selector.select(0)
                if not events:
                    break
                self._handle(events)
            advance()
            self._handle([])

    # ---------------------------------------------------------------- the thread

    def _run(self) -> None:
        while not self._is_closing:
            try:
                events = self._selector.select(self._timeout())
                with self._lock:
                    self._handle(events)
            except Exception as error:  # a defect here or in a link, and clients still want their replies
                self._report(None, "the radio failed", error)
                time.sleep(0.01)

    def _timeout(self) -> float:
        """Return for how long nothing happens unless a packet comes (s)."""
        timeout = self._rest_s
        if self._link is not None and self.link_rate > 0.0:
            wait = self._link.next_arrival() - self._link_clock()
            timeout = min(timeout, max(0.0, wait / self.link_rate))
        return timeout

    def _wake_for(self, radio: DroneRadio) -> None:
        if not radio.has_output:
            radio.has_output = True
            self._with_output.append(radio)
        if threading.get_ident() != self._thread.ident:
            self.wake()

    def _handle(self, events: list[tuple[selectors.SelectorKey, int]]) -> None:
        now = self._clock()
        # after a pause of this thread (process stopped, machine busy) the silence of a client is no timeout
        was_deaf = now - self._latest_turn > _DEAF_S and not self._was_deaf
        if was_deaf or self._was_deaf:
            # owners first, before another client is given what seems to be free
            events.sort(key=lambda event: event[0].data is None or event[0].fileobj is event[0].data.socket)
        elif now < self._settled_at:
            # what came to the shared socket was sent before
            events.sort(key=lambda event: event[0].data is not None and event[0].fileobj is event[0].data.private)
        self._latest_turn, self._was_deaf = now, was_deaf
        for key, _ in events:
            if key.data is None:
                with suppress(OSError):
                    self._wake_out.recv(64)
            else:
                self._receive(key.data, key.fileobj, now)
                if key.data.private_for != key.data.session.address:
                    self._make_private(key.data, now)
        # before the check for output: packets sent after this wake the thread again
        self._is_awake = False
        if self._link is not None:
            self._fetch_arrivals(now)
        if self._turns.has_ended or self.link_rate <= 0.0:
            self._answer_in_turn(now)
        for _ in range(len(self._with_output)):
            self._send_output(self._with_output.popleft(), now)
        if not was_deaf and (now >= self._next_look or now + _LOOK_S < self._next_look):
            self._next_look = now + _LOOK_S
            self._look(now)

    def _look(self, now: float) -> None:
        """Do what is to be done for every drone from time to time."""
        self._rest_s = _IDLE_S
        self._answer_in_turn(now)
        for radio in self._turns.waiting:
            radio.session.wait_for_answer(now)
            radio.heard_by_drone_at = now
        for radio in self._radios:
            self._look_who_is_gone(radio, now)
            for look in tuple(radio.station.context.looks):
                look()
            if radio.private_for != radio.session.address:
                self._make_private(radio, now)
            if radio.session.address is not None:
                self._rest_s = min(self._rest_s, _LOOK_S)

    # ---------------------------------------------------------------- up

    def _receive(self, radio: DroneRadio, opened: Any, now: float) -> None:
        if opened is radio.private:
            # mostly there is one packet: to look for a second one costs as much as to read the first
            try:
                datagram, address = opened.recvfrom(LONGEST)
            except OSError:
                self._hear_of_gone(radio, now)
            else:
                # of another client, what came before the socket was connected
                self._rule(radio, datagram, address, now)
            return
        for number in range(_MAX_DATAGRAMS):
            try:
                got = receive(opened)
            except OSError:
                if opened.fileno() < 0:
                    return  # closed in a turn of the other thread
                self._hear_of_gone(radio, now)
                continue
            if got is None:
                if number == 0:
                    # an error that is not read would wake the thread without end
                    self._hear_of_gone(radio, now)
                return
            self._rule(radio, *got, now)

    def _rule(self, radio: DroneRadio, datagram: bytes, address: Address, now: float) -> None:
        """Do with a datagram what the rule for clients says."""
        counts, session = radio.counts, radio.session
        counts.received += 1
        previous = session.address
        if not self._budget(radio, datagram, address).take(now):
            counts.rate_limited += 1
            return
        if radio.power.state is not Power.ON or is_power_request(datagram):
            self._switch(radio, datagram, address, now)
            return
        ruling = session.hear(address, datagram, now)
        if ruling is Ruling.TAKE:
            self._send_up(radio, datagram, now)
        elif ruling is Ruling.BEGIN:
            self._end(radio, now, "new session" if address == previous else "next client", previous)
            self._send_up(radio, datagram, now)
        elif ruling is Ruling.NULL:
            if address == previous:
                radio.heard_by_drone_at = now
            counts.scans += 1
            with suppress(OSError):
                radio.socket.sendto(NULL, address)
        elif ruling is Ruling.KEEP or ruling is Ruling.REFUSE:
            self._refuse(radio, address, now)
            if self._probes(radio, previous, now) and ruling is Ruling.REFUSE and self._frees(radio, now):
                self._rule(radio, datagram, address, now)
        else:
            counts.malformed += 1

    def _budget(self, radio: DroneRadio, datagram: bytes, address: Address) -> TokenBucket:
        """Return the remaining budget of the sender of a datagram."""
        if address == radio.session.address:
            return radio.of_client
        # a request that is not repeated shall get through while others send garbage
        return radio.of_newcomers if is_link_source(datagram) else radio.of_strangers

    def _probes(self, radio: DroneRadio, owner: Address | None, now: float) -> bool:
        """Send the client of a drone a null packet now and then; return whether one was sent."""
        if owner is None or not radio.of_probes.take(now):
            return False
        # should its socket be closed, the operating system says so at once
        with suppress(OSError):
            radio.socket.sendto(NULL, owner)
        return True

    def _frees(self, radio: DroneRadio, now: float) -> bool:
        """Return whether the client of a drone has turned out to be gone."""
        return self._hear_of_gone(radio, now) and radio.session.address is None

    def _switch(self, radio: DroneRadio, datagram: bytes, address: Address, now: float) -> None:
        """Do with a datagram what the radio chip does, by itself or while the rest of the drone is without power."""
        answer = None
        if is_power_request(datagram):
            booted = radio.power.boots
            answer = radio.power.receive(datagram)
            if radio.power.state is not Power.ON or radio.power.boots != booted:
                self._end(radio, now, "power")
                radio.session.leave()
        elif datagram[:1] and datagram[0] & 0xF3 == 0xF3 and radio.power.state is Power.RADIO_ONLY:
            answer = NULL
        if answer is not None:
            with suppress(OSError):
                radio.socket.sendto(answer, address)

    def _refuse(self, radio: DroneRadio, address: Address, now: float) -> None:
        radio.counts.refused += 1
        if not radio.has_refused:
            radio.has_refused = True
            self._note(radio, now, "radio_refused", client=_named(address), owner=_named(radio.session.address))

    def _send_up(self, radio: DroneRadio, datagram: bytes, now: float) -> None:
        if self._link is not None:
            self._link.send(self._link_clock(), radio.name, Direction.UP, _Letter.of(radio, datagram))
        else:
            self._deliver(radio, datagram, now)

    def _deliver(self, radio: DroneRadio, datagram: bytes, now: float) -> None:
        """Let the drone have a packet, and send its replies, when it is its turn."""
        radio.counts.taken += 1
        radio.heard_by_drone_at = now
        if not radio.is_open:
            self._begin(radio, now)
        # in lockstep there is no wall clock to wait by
        in_turns = self.link_rate > 0.0 and radio.station.context.reads_ahead
        if not (in_turns and self._turns.hold(radio, datagram, now)):
            self._answer(radio, datagram, now)

    def _answer_in_turn(self, now: float) -> None:
        """Answer the requests whose turn has come."""
        turns = self._turns
        for radio, datagram in turns.release(now) if self.link_rate > 0.0 else turns.release_all():
            self._answer(radio, datagram, now)

    def _answer(self, radio: DroneRadio, datagram: bytes, now: float) -> None:
        try:
            replies = radio.station.receive(datagram)
        except Exception as error:  # a defect of a service, and not the end of the others
            radio.counts.errors += 1
            self._report(radio, f"packet {datagram.hex(' ')} was not answered", error)
            return
        for reply in replies:
            radio.counts.replied += 1
            self._send_down(radio, reply, False, now)

    def _fetch_arrivals(self, now: float) -> None:
        """Take what has come through the link."""
        link = self._link
        assert link is not None
        link_now = self._link_clock()
        # what is delivered may be answered, and the answer arrive at once
        for _ in range(_MAX_DATAGRAMS):
            arrivals = link.arrivals(link_now)
            if not arrivals:
                return
            for name, direction, datagram in arrivals:
                radio = self._by_name[name]
                if isinstance(datagram, _Letter) and _is_stale(radio, direction, datagram):
                    radio.counts.dropped += 1
                elif direction is Direction.UP:
                    self._deliver(radio, datagram, now)
                else:
                    self._emit(radio, datagram, False, now)

    # ---------------------------------------------------------------- down

    def _send_output(self, radio: DroneRadio, now: float) -> None:
        """Send what services sent of their own accord; what may be dropped, within its budget."""
        radio.has_output = False
        for _ in range(len(radio.unsent)):
            if not self._may_reply(radio, radio.unsent[0], now):
                self._hold_back(radio)
                break
            self._emit(radio, radio.unsent.popleft(), False, now)
        counts, session = radio.counts, radio.session
        is_silent = not self._was_deaf and now - session.heard_at > STALL_SHARE * self._silence_s
        is_behind = not radio.is_open or session.address is None or is_silent
        for datagram, droppable in radio.station.context.take_out():
            if not radio.is_open or (droppable and (is_behind or not radio.of_logs.take(now))):
                counts.dropped += 1
            else:
                counts.sent += 1
                self._send_down(radio, datagram, droppable, now)

    def _send_down(self, radio: DroneRadio, datagram: bytes, droppable: bool, now: float) -> None:
        if self._link is not None:
            self._link.send(self._link_clock(), radio.name, Direction.DOWN, _Letter.of(radio, datagram), droppable)
        elif droppable or (not radio.unsent and self._may_reply(radio, datagram, now)):
            self._emit(radio, datagram, droppable, now)
        elif len(radio.unsent) < _MAX_UNSENT:
            radio.unsent.append(datagram)
            self._hold_back(radio)
        else:
            radio.counts.lost += 1

    def _may_reply(self, radio: DroneRadio, datagram: bytes, now: float) -> bool:
        """Tell whether a client has room for an answer; in lockstep no time passes in which it could read.

        Tables and values of parameters and logs go by what the client has asked for already (`toc`), never by time.
        """
        return self.link_rate <= 0.0 or datagram[0] >> 4 in _ASKED_IN_TURN or radio.of_replies.take(now)

    def _hold_back(self, radio: DroneRadio) -> None:
        """Look again soon at what was not sent."""
        self._wake_for(radio)
        self._rest_s = _RETRY_S

    def _emit(self, radio: DroneRadio, datagram: bytes, droppable: bool, now: float) -> None:
        """Hand a datagram to the operating system, for the client."""
        address = radio.session.address
        while address is not None and address == radio.session.address:
            try:
                if radio.private is not None and radio.private_for == address:
                    radio.private.send(datagram)
                else:
                    radio.socket.sendto(datagram, address)
                return
            except BlockingIOError:
                if not droppable and len(radio.unsent) < _MAX_UNSENT:
                    radio.unsent.append(datagram)
                    self._hold_back(radio)
                    return
                break
            except ConnectionError:
                # of an earlier datagram, perhaps to another client; this one was not sent
                if not self._hear_of_gone(radio, now):
                    break
            except OSError:
                break
        if droppable:
            radio.counts.dropped += 1
        else:
            radio.counts.lost += 1

    # ---------------------------------------------------------------- sessions

    def _begin(self, radio: DroneRadio, now: float) -> None:
        radio.is_open = True
        radio.has_refused = False
        radio.counts.sessions += 1
        self._note(radio, now, "radio_session", phase="begin", client=_named(radio.session.address))

    def _end(self, radio: DroneRadio, now: float, reason: str, client: Address | None = None) -> None:
        """End a session, if there is one."""
        if not radio.is_open:
            return
        radio.is_open = False
        self._turns.forget(radio)
        try:
            radio.station.end_session()
        except Exception as error:
            radio.counts.errors += 1
            self._report(radio, "the session was not ended properly", error)
        radio.counts.dropped += len(radio.station.context.take_out())
        radio.unsent.clear()
        self._note(
            radio, now, "radio_session", phase="end", reason=reason, client=_named(client or radio.session.address)
        )
        radio.owes_relax = True
        self.when_a_session_ended()

    def _look_who_is_gone(self, radio: DroneRadio, now: float) -> None:
        if radio.is_open and now - radio.heard_by_drone_at > self._silence_s:
            self._end(radio, now, "silence")
        if radio.session.is_gone(now):
            self._end(radio, now, "silence")
            radio.session.leave()
        self._serve_next(radio, now)

    def _serve_next(self, radio: DroneRadio, now: float) -> None:
        """Hand a free drone to the next client in the queue."""
        if radio.power.state is not Power.ON:
            return
        previous = radio.session.address
        request = radio.session.next_in_line(now)
        if request is not None:
            self._end(radio, now, "next client", previous)
            self._send_up(radio, request, now)

    def _hear_of_gone(self, radio: DroneRadio, now: float) -> bool:
        """Ask the operating system which clients are gone. Returns whether there were any."""
        gone = read_refusals(radio.socket)
        if radio.private is not None:
            gone += read_refusals(radio.private)
        session = radio.session
        for address in gone:
            session.forget(address)
            if session.address == address:
                self._end(radio, now, "gone")
                session.leave()
                self._serve_next(radio, now)
        return bool(gone)

    def _make_private(self, radio: DroneRadio, now: float) -> None:
        """Bind the private socket of a drone to its new owner, or release it."""
        late: list[tuple[bytes, Address]] = []
        owner = radio.session.address
        private = radio.private
        if private is not None and not (is_for_one_address(radio.socket) and turn_to(private, owner)):
            # nothing comes any more, so that what is read here is all
            turn_to(private, None)
            late += _waiting_at(private)
            self._selector.unregister(private)
            private.close()
            radio.private = None
        radio.private_for = owner
        if owner is not None:
            self._rest_s = min(self._rest_s, _LOOK_S)
            if radio.private is None:
                radio.private = open_private(radio.socket, owner)
                if radio.private is not None:
                    self._selector.register(radio.private, selectors.EVENT_READ, radio)
        # what the new owner sent before it had a socket of its own comes before what it sent since: all of it is read
        # before the other socket is
        self._settled_at = now + _SETTLES_S
        late += _waiting_at(radio.socket)
        for datagram, address in late:
            self._rule(radio, datagram, address, now)

    # ---------------------------------------------------------------- notes and reports

    def _note(self, radio: DroneRadio, now: float, kind: str, **details: str) -> None:
        """Have the world remember something; too much of it is forgotten."""
        if radio.of_notes.take(now):
            context = radio.station.context
            context.later(partial(context.world.note, kind, radio.name, **details))

    def _report(self, radio: DroneRadio | None, sentence: str, error: Exception) -> None:
        report(self._reported, radio.name if radio is not None else "all drones", sentence, error)


def report(reported: set[tuple[str, str]], name: str, sentence: str, error: Exception) -> None:
    """Log an error with its traceback, but each kind at each drone once."""
    kind = (name, type(error).__name__)
    if kind not in reported and len(reported) < _MAX_REPORTS:
        reported.add(kind)
        logger.error("%s: %s: %s: %s", name, sentence, type(error).__name__, error, exc_info=error)


def _named(address: Address | None) -> str:
    return f"{address[0]}:{address[1]}" if address is not None else "nobody"


def _is_stale(radio: DroneRadio, direction: Direction, letter: _Letter) -> bool:
    """Tell whether a packet has been overtaken by another client, or by another session of its own."""
    client = radio.session.address
    if direction is Direction.UP:
        # the drone still gets the last packets of a client that has disconnected
        return client is not None and client != letter.client
    return client != letter.client or radio.counts.sessions != letter.session


def _waiting_at(opened: socket.socket) -> list[tuple[bytes, Address]]:
    """Read all datagrams that have come; refused sends among them are reported later."""
    waiting: list[tuple[bytes, Address]] = []
    with suppress(OSError):
        while len(waiting) < _MAX_WAITING and (got := receive(opened)) is not None:
            waiting.append(got)
    return waiting
