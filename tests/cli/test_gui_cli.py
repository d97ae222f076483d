"""`crazychoir gui` and `crazychoir press`, as far as they go without a browser."""

import contextlib
import json
import re
import socket
import threading
from http.server import BaseHTTPRequestHandler, HTTPServer
from pathlib import Path

import pytest
from typer.testing import CliRunner

from crazychoir_fw.cli import app
from crazychoir_fw.cli.gui import Page, bind
from crazychoir_fw.cli.press import command_of


def run(*arguments):
    return CliRunner().invoke(app, [str(argument) for argument in arguments])


def test_a_token_that_no_link_can_hold_is_refused(tmp_path):
    result = run("gui", tmp_path / "mission.yaml", "--host", "0.0.0.0", "--token", "open sesame")
    assert result.exit_code == 2
    assert "--token must be 8 to 200 letters" in result.stderr


def test_a_mission_that_is_not_there_is_one_sentence(tmp_path):
    result = run("gui", tmp_path / "mission.yaml", "--no-browser")
    assert result.exit_code == 2
    assert "mission.yaml cannot be read" in result.stderr


def test_who_comes_when_the_address_is_told_is_not_refused(monkeypatch, capsys):
    """Connections are refused before the address is printed, and queued from then on until the server runs."""
    pytest.importorskip("nicegui")
    listener = bind("127.0.0.1", 0)
    place = listener.getsockname()

    class Ready(contextlib.nullcontext):
        def wait_until_ready(self, timeout_s):
            with pytest.raises(ConnectionRefusedError):
                socket.create_connection(place, timeout=10.0)

    class Server:
        def run(self, sockets):
            said = re.search(r"http://127.0.0.1:(\d+)/", capsys.readouterr().out)
            with socket.create_connection(("127.0.0.1", int(said[1])), timeout=10.0) as client:
                visitor, _ = sockets[0].accept()
                with visitor:
                    assert visitor.getpeername() == client.getsockname()

    monkeypatch.setattr("crazychoir_fw.gui.server.make_server", lambda *_: Server())
    Page("127.0.0.1", listener, None, Path("drawings"), False, None).show(Ready())
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(place, timeout=10.0)


def test_a_port_that_is_taken_is_one_sentence():
    mission = Path(__file__).parents[2] / "examples" / "draw.yaml"
    with bind("127.0.0.1", 0) as taken:
        taken.listen()
        port = taken.getsockname()[1]
        result = run("gui", mission, "--no-browser", "--port", port, "--backend", "integrator")
    assert result.exit_code == 2
    assert result.stderr == f"port {port} of 127.0.0.1 is in use: give another with --port, or 0 for any free one\n"


@pytest.mark.parametrize(
    ("words", "command"),
    [
        ("takeoff", {"name": "takeoff"}),
        ("disarm", {"name": "arm", "armed": False}),
        ("pause", {"name": "speed", "factor": 0.0}),
        ("goto 1 -2 0.5", {"name": "goto", "x": 1.0, "y": -2.0, "z": 0.5}),
        ("set posCtlPid.xKp 2", {"name": "set_parameter", "parameter": "posCtlPid.xKp", "value": 2.0}),
        ("rewind 3", {"name": "rewind", "time": 3.0}),
        ("rewind 3.5 2", {"name": "rewind", "time": 3.5, "branch": 2}),
    ],
)
def test_words_become_commands(words, command):
    button, *values = words.split()
    assert command_of(button, values) == command


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        ("explode", "there is no button 'explode', allowed: takeoff"),
        ("goto 1 2", "goto does not take 1 2"),
        ("rewind 3 1.5", "branch 1.5 must be a whole number"),
        ("goto 1 2 up", "1 2 up: allowed: numbers"),
        ("takeoff", "there is no page at"),
    ],
)
def test_what_cannot_be_pressed_is_one_sentence(words, sentence):
    result = run("press", *words.split(), "--address", "http://127.0.0.1:9")
    assert result.exit_code == 2
    assert sentence in result.stderr


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--port", "9"], "there is no page at http://127.0.0.1:9: nobody listens there; start one with"),
        (["--port", "9", "--address", "http://127.0.0.1:9"], "--port and --address both say where the page is"),
        (["--port", "70000"], "less than or equal to 65535"),
        (["--address", "127.0.0.1:9"], "--address 127.0.0.1:9: allowed: http://HOST:PORT"),
        (["--address", "http://127.0.0.1:nine"], "nonnumeric port: 'nine'"),
    ],
)
def test_where_there_is_no_page_is_said(options, sentence):
    result = run("press", "takeoff", *options)
    assert result.exit_code == 2
    assert sentence in " ".join(result.stderr.replace("│", " ").split())


@pytest.mark.parametrize(
    ("status", "kind", "body", "code", "said"),
    [
        (200, "application/json", '{"ok": true, "text": "STOP: all 2 drones"}', 0, "STOP: all 2 drones"),
        (409, "application/json", '{"ok": false, "text": "nobody flies"}', 1, "nobody flies"),
        (401, "text/plain", "a token is needed", 1, "a token is needed"),
        (404, "text/html", "<h1>somebody else</h1>", 2, "is no page of crazychoir gui: status 404"),
        (200, "application/json", "[]", 2, "is no page of crazychoir gui"),
    ],
)
def test_answers_are_shown(status, kind, body, code, said):
    class Answers(BaseHTTPRequestHandler):
        def do_POST(self):
            asked.append((self.path, json.loads(self.rfile.read(int(self.headers["content-length"])))))
            self.send_response(status)
            self.send_header("content-type", kind)
            self.end_headers()
            self.wfile.write(body.encode())

        def log_message(self, *_):
            pass

    asked = []
    with HTTPServer(("127.0.0.1", 0), Answers) as server:
        thread = threading.Thread(target=server.handle_request)
        thread.start()
        result = run("press", "stop", "--port", server.server_port)
        thread.join()
    assert asked[0][0] == "/api/command"
    assert asked[0][1]["command"] == {"name": "stop", "drones": None}
    assert result.exit_code == code
    assert said in (result.stdout if code == 0 else result.stderr)
