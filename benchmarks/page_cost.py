"""What the page costs a flight: simulated seconds per second with and without browsers, side by side.

    python benchmarks/page_cost.py [--drones 30] [--seconds 10] [--repeats 3] [--chromium PATH | none] [--json FILE]

The flight goes as fast as it can. `served` has one client of the live connection that takes every frame; `watched` has
Chromium with the three-dimensional view of all drones. Without a graphics card Chromium draws with the processor, and
takes cores from the flight: its share is that of a picture on the same machine, and none of it is the server's. With
--pace the flight is held at that speed, as people fly, and what counts is whether it keeps it.
"""

import argparse
import asyncio
import json
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


def factor(session, seconds):
    """Return simulated seconds per second, over so many seconds on the wall."""
    begin, clock = session.experiment.time, time.perf_counter()
    time.sleep(seconds)
    return (session.experiment.time - begin) / (time.perf_counter() - clock)


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

    def __init__(self, path, address):
        from playwright.sync_api import sync_playwright

        self._driver = sync_playwright().start()
        self._browser = self._driver.chromium.launch(executable_path=path, args=ARGUMENTS)
        self._page = self._browser.new_page(viewport={"width": 1000, "height": 700})
        self._page.goto(address)
        self._page.wait_for_function("window.cc && cc.frame && cc.setting && cc.words.cards", timeout=120_000)
        self._page.locator(".q-tab", has_text="Watch").click()
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
    alone, seen = [], {way: [] for way in ways}
    for _ in range(arguments.repeats):
        for way, watch in ways.items():
            alone.append(factor(session, arguments.seconds))
            watcher = watch()
            seen[way].append(factor(session, arguments.seconds) / alone[-1])
            watcher.close()
    server.should_exit = True
    thread.join(timeout=10.0)
    session.close()
    kept = {way: round(statistics.median(shares), 4) for way, shares in seen.items()}
    return {"drones": arguments.drones, "real_time_factor": round(statistics.median(alone), 3), "kept": kept}


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
    print(f"{result['drones']} drones: {result['real_time_factor']:.2f} x real time without a browser")
    for way, share in result["kept"].items():
        print(f"  {way:8s} keeps {100 * share:.0f} %")
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2))


if __name__ == "__main__":
    main()
