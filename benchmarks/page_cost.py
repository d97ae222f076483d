"""What the page costs a flight: simulated seconds per second with and without browsers, side by side.

    python benchmarks/page_cost.py [--drones 30] [--seconds 10] [--repeats 3] [--pace 1] [--chromium PATH | none]

`served` has one client of the live connection that takes every frame: all that is the server's. `watched` has Chromium
with the three-dimensional view of all drones, and `polite` the same with the least priority (nice 19): it stands for a
browser on other processors, since it takes what the flight leaves. Without a graphics card Chromium draws with the
processor; how much of one it takes is its own column. With --pace the flight is held at that speed, as people fly, and
what counts is whether it keeps it; otherwise it goes as fast as it can.

Seconds on the wall are those of everybody on the machine. The processor time of the flight for a simulated second, of
the server for a second, and of the browser are not.
"""

import argparse
import asyncio
import json
import os
import shutil
import statistics
import threading
import time
from pathlib import Path

from crazychoir_fw.gui.server import make_server
from crazychoir_fw.gui.session import Session
from crazychoir_fw.mission.loader import parse_mission

ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
AS_FAST_AS_IT_CAN = 100.0


def mission_of(drones):
    """Drones in rows of six, one meter apart, each with a neighbor."""
    fleet = [{"id": f"cf{k}", "position": [k % 6 - 2.5, k // 6 - 2.0]} for k in range(drones)]
    graph = [[f"cf{k}", f"cf{k + 1}"] for k in range(drones - 1)]
    layers = {
        "rate": 100,
        "communication": {"graph": graph},
        "guidance": {"class": "SimpleGuidance", "height": 1.0},
        "planning": {"class": "Spline"},
        "control": {"class": "HierarchicalController", "sender": "FPQRSender", "gains": "mujoco"},
    }
    return parse_mission(
        {"name": "page", "drones": fleet, "layers": layers, "flight": [{"takeoff": {"duration": 2.0}}]}
    )


def processor_time(pid, thread=None):
    """Return the processor time (s) of a process, or of one of its threads; 0 if it has gone."""
    try:
        text = Path(f"/proc/{pid}/stat" if thread is None else f"/proc/{pid}/task/{thread}/stat").read_text()
    except OSError:
        return 0.0
    fields = text.rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def children_of(pid):
    """Return the processes that a process has started, and those that they have."""
    found = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            direct = [int(word) for word in task.read_text().split()]
        except OSError:
            continue
        for child in direct:
            found += [child, *children_of(child)]
    return found


class Meter:
    """Speed of a flight, and processor time of everybody who has to do with it."""

    def __init__(self, session, flight, server):
        self._session, self._threads = session, {"flight": flight, "server": server}

    def _now(self):
        me = os.getpid()
        used = {name: processor_time(me, thread.native_id) for name, thread in self._threads.items()}
        browser = {child: processor_time(child) for child in children_of(me)}
        return self._session.experiment.time, time.perf_counter(), used, browser

    def measure(self, seconds):
        """Return simulated seconds per second, and processor time, over so many seconds on the wall."""
        begin, clock, used, browser = self._now()
        time.sleep(seconds)
        end, later, more, browsing = self._now()
        flown, waited = end - begin, later - clock
        return {
            "factor": flown / waited,
            "flight_per_simulated_s": (more["flight"] - used["flight"]) / max(flown, 1e-9),
            "server_share": (more["server"] - used["server"]) / waited,
            "browser_share": sum(max(0.0, v - browser.get(pid, 0.0)) for pid, v in browsing.items()) / waited,
        }


class Client:
    """Takes every frame, as a browser does, and draws none."""

    def __init__(self, address):
        self._address = address.replace("http", "ws") + "/api/live"
        self._origin = address
        self.frames = 0
        self._stop = threading.Event()
        self._thread = threading.Thread(target=lambda: asyncio.run(self._listen()), daemon=True)
        self._thread.start()

    async def _listen(self):
        import websockets

        async with websockets.connect(self._address, origin=self._origin, max_size=None) as socket:
            while not self._stop.is_set():
                self.frames += isinstance(await socket.recv(), bytes)

    def close(self):
        self._stop.set()
        self._thread.join(timeout=5.0)


class Chromium:
    """A browser on the tab Watch, in a process of its own and driven from a thread."""

    def __init__(self, path, address, is_polite=False):
        from playwright.sync_api import sync_playwright

        self._driver = sync_playwright().start()
        self._browser = self._driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        self._page = self._browser.new_page(viewport={"width": 1000, "height": 700})
        self._page.goto(address)
        self._page.wait_for_function("window.cc && cc.frame && cc.setting && cc.words.cards", timeout=120_000)
        self._page.locator(".q-tab", has_text="Watch").click()
        if is_polite:
            for child in children_of(os.getpid()):
                for task in Path(f"/proc/{child}/task").glob("*"):  # new threads have it from those that start them
                    os.setpriority(os.PRIO_PROCESS, int(task.name), 19)
        time.sleep(3.0)

    def close(self):
        self._browser.close()
        self._driver.stop()


def measure(arguments):
    session = Session(mission_of(arguments.drones), arguments.pace or AS_FAST_AS_IT_CAN).open()
    session.wait_until_ready()
    server = make_server(session, port=0)
    thread = threading.Thread(target=server.run, daemon=True)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    address = f"http://127.0.0.1:{server.servers[0].sockets[0].getsockname()[1]}"
    session.ask(session.experiment.takeoff).result()
    time.sleep(min(2.0, arguments.seconds))
    ways = {"served": lambda: Client(address)}
    if arguments.chromium != "none":
        ways["watched"] = lambda: Chromium(arguments.chromium, address)
        ways["polite"] = lambda: Chromium(arguments.chromium, address, is_polite=True)
    meter = Meter(session, next(t for t in threading.enumerate() if t.name == "flight"), thread)
    alone, seen = [], {way: [] for way in ways}
    for _ in range(arguments.repeats):
        for way, watch in ways.items():
            alone.append(meter.measure(arguments.seconds))
            watcher = watch()
            seen[way].append(meter.measure(arguments.seconds))
            seen[way][-1]["kept"] = seen[way][-1]["factor"] / alone[-1]["factor"]
            watcher.close()
    server.should_exit = True
    thread.join(timeout=10.0)
    session.close()
    return {"drones": arguments.drones, "alone": medians(alone), **{way: medians(rows) for way, rows in seen.items()}}


def medians(rows):
    """Return the median of each column."""
    return {name: round(statistics.median(row[name] for row in rows), 4) for name in rows[0]}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--drones", type=int, default=30)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--pace", type=float, help="simulated seconds per second; otherwise as fast as it goes")
    parser.add_argument("--chromium", default=shutil.which("chromium") or "none", help="path of Chromium, or none")
    parser.add_argument("--json", type=Path)
    arguments = parser.parse_args()
    result = measure(arguments)
    alone = result["alone"]
    print(
        f"{result['drones']} drones: {alone['factor']:.2f} x real time without a browser, "
        f"{1000.0 * alone['flight_per_simulated_s']:.0f} ms of a processor for a simulated second"
    )
    for way in (way for way in ("served", "watched", "polite") if way in result):
        row = result[way]
        print(
            f"  {way:8s} keeps {100 * row['kept']:.0f} %; a simulated second takes "
            f"{1000.0 * row['flight_per_simulated_s']:.0f} ms, the server {100 * row['server_share']:.1f} % "
            f"of a processor, the browser {100 * row['browser_share']:.0f} %"
        )
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
