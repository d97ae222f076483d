"""What tests of the page share: flights, and a browser."""

import json
import os
import shutil
import threading
import time
import uuid
from pathlib import Path

import pytest

pytest.importorskip("nicegui")

from crazychoir_fw.gui.opening import open_mission
from crazychoir_fw.gui.session import Session

EXAMPLES = Path(__file__).parents[2] / "examples"
CHROMIUM_OPTIONS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@pytest.fixture(scope="module")
def open_flight():
    """Opens flights, and ends them with the module."""
    opened = []

    def open_one(name="draw.yaml", speed=0.0, **overrides):
        session = Session(open_mission(EXAMPLES / name, **overrides), speed).open()
        opened.append(session)
        session.wait_until_ready()
        return session

    yield open_one
    for session in opened:
        session.close()


@pytest.fixture
def until():
    """Waits until something holds."""

    def wait(condition, timeout_s=60.0, tell=lambda: ""):
        end = time.monotonic() + timeout_s
        while not condition():
            assert time.monotonic() < end, f"it never came about; {tell()}"
            time.sleep(0.02)

    return wait


class Served:
    """A server in a thread."""

    def __init__(self, server):
        self.server = server
        self._thread = threading.Thread(target=server.run, daemon=True)
        self._thread.start()
        end = time.monotonic() + 30.0
        while not server.started:
            assert time.monotonic() < end, "the server did not start"
            time.sleep(0.01)
        port = server.servers[0].sockets[0].getsockname()[1]
        self.address = f"http://127.0.0.1:{port}"

    def end(self):
        self.server.should_exit = True
        self._thread.join(timeout=10.0)


@pytest.fixture(scope="module")
def serve():
    """Serves a flight, with the page."""
    from crazychoir_fw.gui.server import make_server

    opened = []

    def serve_one(session, folder):
        opened.append(Served(make_server(session, port=0, folder=folder)))
        return opened[-1]

    yield serve_one
    for served in opened:
        served.end()


@pytest.fixture(scope="module")
def browser():
    """Headless Chromium."""
    from playwright.sync_api import sync_playwright

    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.skip("Chromium is not installed (Debian: apt install chromium), and CHROMIUM names none")
    with sync_playwright() as driver:
        chromium = driver.chromium.launch(executable_path=path, args=CHROMIUM_OPTIONS)
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def api():
    """Makes clients of the endpoints of a flight, without the page."""
    import httpx

    from crazychoir_fw.gui.server import make_app

    class Client:
        def __init__(self, session, folder, token=None, host="localhost"):
            import anyio

            self._run = anyio.run
            self.app = make_app(session, folder, token, with_page=False)
            self.host = host

        def request(self, method, path, **options):
            async def ask():
                transport = httpx.ASGITransport(app=self.app)
                async with httpx.AsyncClient(transport=transport, base_url=f"http://{self.host}") as client:
                    return await client.request(method, path, **options)

            return self._run(ask)

        def get(self, path, **options):
            return self.request("GET", path, **options)

        def post(self, path, data=None, **options):
            if data is not None:
                options["content"] = json.dumps(data)
                options.setdefault("headers", {})["content-type"] = "application/json"
            return self.request("POST", path, **options)

        def command(self, command_id=None, **command):
            body = {"id": command_id or uuid.uuid4().hex, "command": command}
            return self.post("/api/command", body).json()

        def draw(self, **change):
            return self.post("/api/drawings", {"id": uuid.uuid4().hex, "change": change}).json()

    return Client
