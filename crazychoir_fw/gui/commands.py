"""Carries out what browsers ask for; each with a sentence as its answer, or an error that is one."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future
from functools import singledispatchmethod
from typing import TYPE_CHECKING, Any

import numpy as np

from crazychoir_fw.common.errors import StateError, UnknownNameError
from crazychoir_fw.flight.access import reboot_all
from crazychoir_fw.flight.start_transit import StartTransit, cannot_be_sent
from crazychoir_fw.gui import requests as asked
from crazychoir_fw.gui.flying import Flying, Leg, duration_of, go_to
from crazychoir_fw.gui.mission_run import MissionRun, starts_something

if TYPE_CHECKING:
    from crazychoir_fw.gui.previews import Previews
    from crazychoir_fw.gui.session import Session

_BUTTONS = {"takeoff": "TAKE-OFF", "land": "LAND", "stop": "STOP", "start": "START"}


class Commands:
    """The one way from browsers to the flight."""

    def __init__(self, session: Session, previews: Previews) -> None:
        self._session = session
        self._previews = previews

    def send(self, envelope: asked.Envelope) -> Future[str]:
        """Carry out a command, once for each id; returns what will hold the answer."""
        return self._session.once(envelope.id, lambda: self._send(envelope.command))

    def _send(self, command: Any) -> Future[str]:
        session = self._session
        self._chosen(getattr(command, "drones", None))  # unknown names are refused before anything is asked
        if isinstance(command, asked.Press) and command.name == "stop" and session.access is not None:
            # a round of real drones may take seconds, when some of them are made ready
            session.access.stop_now(self._chosen(command.drones))
        if isinstance(command, asked.SetParameter) and self._is_slow(command):
            return _aside(lambda: self._set_slowly(command))
        return session.ask(lambda: self._do(command))

    def _is_slow(self, command: asked.SetParameter) -> bool:
        access = self._session.access
        return access is not None and any(access.is_slow(i) for i in self._chosen(command.drones))

    def _do(self, command: Any) -> str:
        text = self.carry_out(command)
        session = self._session
        session.say("command", text)
        if not isinstance(command, asked.SetSpeed):
            mark = {"time": round(session.experiment.time, 2), "text": text}
            session.branches.present.marks.append(mark)
        return text

    def _chosen(self, drones: list[str] | None) -> list[int]:
        names = self._session.names
        if drones is None:
            return list(range(len(names)))
        for name in drones:
            if name not in names:
                raise UnknownNameError(f"there is no drone '{name[:40]}', allowed: {', '.join(names[:30])}")
        return [names.index(name) for name in dict.fromkeys(drones)]

    def _whom(self, chosen: list[int]) -> str:
        names = self._session.names
        if len(chosen) == len(names) > 1:
            return f"all {len(names)} drones"
        listed = ", ".join(names[i] for i in chosen[:5])
        return listed + (f" and {len(chosen) - 5} more" if len(chosen) > 5 else "")

    # ---------------------------------------------------------------- each kind

    @singledispatchmethod
    def carry_out(self, command: Any) -> str:
        """Carry out a command between two rounds; returns what was done."""
        raise StateError(f"nobody knows how to {command!r}")

    @carry_out.register
    def _(self, command: asked.Press) -> str:
        session = self._session
        experiment, chosen = session.experiment, self._chosen(command.drones)
        names = [session.names[i] for i in chosen]
        self._check_press(command.name, chosen)
        if session.flying is not None:
            session.flying.without(chosen)
        getattr(experiment, command.name)(names)
        failed = [i for i in chosen if experiment.agents[i].failure] if command.name in ("takeoff", "start") else []
        reasons = "; ".join(str(experiment.agents[i].failure) for i in failed)
        if len(failed) == len(chosen):
            raise StateError(reasons)
        text = f"{_BUTTONS[command.name]}: {self._whom([i for i in chosen if i not in failed])}"
        return f"{text}; but {reasons}" if failed else text

    def _check_press(self, name: str, chosen: list[int]) -> None:
        """Refuse a button that can do nothing now."""
        session = self._session
        if name == "start" and not starts_something(session.mission):
            raise StateError("START: these drones wait for GO TO and FLY; press MISSION for the phases of the mission")
        if name in ("takeoff", "start"):
            self._check_ready(chosen)
        elif name == "land" and not any(session.experiment.agents[i].is_up for i in chosen):
            raise StateError(f"LAND: no drone flies ({self._whom(chosen)})")

    def _check_ready(self, chosen: list[int]) -> None:
        session = self._session
        for i in chosen:
            agent = session.experiment.agents[i]
            reason = agent.failure and f"{agent.failure}; REBOOT helps"
            reason = reason or (None if agent.is_up else session.access.refusal(i))
            if reason:
                raise StateError(reason)
        resting = [i for i in chosen if not session.experiment.agents[i].is_up]
        if resting:
            session.call_roll(resting)

    @carry_out.register
    def _(self, command: asked.GoTo) -> str:
        session = self._session
        experiment, chosen = session.experiment, self._chosen(command.drones)
        flying = [i for i in chosen if experiment.agents[i].is_up]
        if not flying:
            raise StateError(f"GO TO: {self._whom(chosen)} must fly first; press TAKE-OFF")
        for i in flying:
            if reason := cannot_be_sent(experiment, experiment.agents[i]):
                raise StateError(reason)
        if session.flying is not None:
            session.flying.without(flying)
        position = experiment.backend.poses().position[flying]
        goal = np.array([command.x, command.y, command.z])
        places = position - position.mean(axis=0)
        places[:, 2] = 0.0
        seconds = command.duration or duration_of(float(np.linalg.norm(goal + places - position, axis=1).max()))
        for i, place in zip(flying, places, strict=True):
            go_to(experiment, experiment.agents[i], goal + place, seconds)
        where = f"({command.x:.2f}, {command.y:.2f}, {command.z:.2f}) m in {seconds:.1f} s"
        return f"GO TO {where}: {self._whom(flying)}"

    @carry_out.register
    def _(self, command: asked.GoToStarts) -> str:
        session = self._session
        experiment, chosen = session.experiment, self._chosen(command.drones)
        flying = [experiment.agents[i] for i in chosen if experiment.agents[i].is_up]
        if not flying:
            raise StateError(f"GO TO STARTS: {self._whom(chosen)} must fly first; press TAKE-OFF")
        reasons = [cannot_be_sent(experiment, agent) for agent in flying]
        if all(reasons) or (command.drones and any(reasons)):
            raise StateError(next(filter(None, reasons)))
        if session.flying is not None:
            raise StateError(f"GO TO STARTS: '{session.flying.name}' is being flown; LAND or STOP ends it")
        session.flying = transit = StartTransit(experiment, session.mission, [agent.name for agent in flying])
        return f"GO TO STARTS ({transit.duration:.0f} s): {self._whom(transit.movers)}"

    @carry_out.register
    def _(self, command: asked.Arm) -> str:
        chosen = self._chosen(command.drones)
        for i in chosen:
            self._session.access.arm(i, command.armed)
        return f"{'ARM' if command.armed else 'DISARM'}: {self._whom(chosen)}"

    @carry_out.register
    def _(self, command: asked.Reboot) -> str:
        session, chosen = self._session, self._chosen(command.drones)
        expected = reboot_all([session.experiment.agents[i] for i in chosen], session.access)
        return f"REBOOT: {self._whom(chosen)}; {expected}"

    @carry_out.register
    def _(self, command: asked.SetParameter) -> str:
        chosen = self._chosen(command.drones)
        values = [self._session.access.set_parameter(i, command.parameter, command.value) for i in chosen]
        return f"{command.parameter} = {values[0]:.7g}: {self._whom(chosen)}"

    def _set_slowly(self, command: asked.SetParameter) -> str:
        """Write a parameter where some drones take their time: the flight does not wait for those."""
        session, chosen, values = self._session, self._chosen(command.drones), []
        for i in chosen:

            def write(i: int = i) -> float:
                return session.access.set_parameter(i, command.parameter, command.value)

            values.append(write() if session.access.is_slow(i) else session.ask(write).result())
        return f"{command.parameter} = {values[0]:.7g}: {self._whom(chosen)}"

    @carry_out.register
    def _(self, command: asked.SetSpeed) -> str:
        sentence = self._session.access.no_speed
        if sentence is None and self._session.experiment.backend.is_real_time:
            sentence = "the time of real drones goes on by itself"
        if sentence is not None:
            raise StateError(sentence)
        self._session.speed = command.factor
        return "PAUSE" if command.factor == 0.0 else f"SPEED: {command.factor:g} x real time"

    @carry_out.register
    def _(self, command: asked.Rewind) -> str:
        now = self._session.go_back(command.branch, command.time)
        return f"REWIND: back to {now:.2f} s, branch {self._session.branches.present.number}"

    @carry_out.register
    def _(self, command: asked.Fly) -> str:
        session = self._session
        preview = self._previews.find(command.preview)
        legs = [Leg(part.drone, part.fit.curve) for part in preview.parts]
        self._check_ready([leg.drone for leg in legs])
        session.flying = Flying(session.experiment, session.access, legs, preview.name)
        chosen = [leg.drone for leg in legs]
        onboard = [session.names[i] for i in chosen if session.experiment.agents[i].planner is None]
        how = "uploaded to the trajectory memory" if onboard else "streamed"
        return f"FLY '{preview.name}' ({how}): {self._whom(chosen)}"

    @carry_out.register
    def _(self, command: asked.FlyMission) -> str:
        session = self._session
        self._check_ready(self._chosen(None))
        session.flying = run = MissionRun(session.experiment, session.access, session.mission)
        return f"MISSION '{run.name}' ({run.duration:.0f} s): {self._whom(self._chosen(None))}"


def _aside(action: Callable[[], Any]) -> Future[Any]:
    """Do something in a thread of its own: what comes next, perhaps STOP, waits for nothing."""
    future: Future[Any] = Future()

    def work() -> None:
        try:
            future.set_result(action())
        except Exception as error:
            future.set_exception(error)

    threading.Thread(target=work, name="command", daemon=True).start()
    return future
