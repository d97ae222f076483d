"""The endpoints of the page, without a browser: what they do, and what they refuse."""

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.gui.requests import Envelope, PreviewRequest, read
from crazychoir_fw.gui.server import token_for

LINE = [[0.1 * k, 0.0, 0.1 * k] for k in range(20)]


@pytest.fixture(scope="module")
def session(open_flight):
    return open_flight("draw.yaml", speed=0.0, backend="integrator")


@pytest.fixture(scope="module")
def client(session, api, tmp_path_factory):
    return api(session, tmp_path_factory.mktemp("drawings"))


def test_buttons_answer_in_sentences(client, session):
    assert client.command(name="land")["text"] == "LAND: no drone flies (all 4 drones)"
    assert client.command(name="goto", x=0, y=0, z=1)["text"].endswith("must fly first; press TAKE-OFF")
    assert client.command(name="takeoff", drones=["agent_9"])["text"].startswith("there is no drone 'agent_9', allowed")
    assert client.command(name="takeoff", drones=["agent_1"]) == {"ok": True, "text": "TAKE-OFF: agent_1"}
    assert [agent.is_up for agent in session.experiment.agents] == [False, True, False, False]
    assert client.command(name="stop")["text"] == "STOP: all 4 drones"
    assert not any(agent.is_up for agent in session.experiment.agents)


@pytest.mark.parametrize("word", ["arm", "reboot"])
def test_point_masses_have_nothing_to_arm_or_to_reboot(client, word):
    assert client.get("/api/setting").json()["has_software"] is False
    assert client.command(name=word)["text"].startswith("agent_0: a drone of this backend has no")


def test_a_command_is_carried_out_once(client, session):
    before = len(session.experiment.events)
    answers = [client.command("the-same", name="takeoff", drones=["agent_0"]) for _ in range(5)]
    assert all(answer == answers[0] for answer in answers)
    assert len(session.experiment.events) == before + 1
    client.command(name="stop")


def test_drawings_are_changed_undone_saved_and_loaded(client):
    assert client.draw(action="delete")["drawings"] == []
    drawing = client.draw(action="add", points=LINE, height=0.7, name="one")["drawings"][0]
    assert (drawing["drone"], drawing["height"], drawing["points"][-1]) == ("agent_0", 0.7, [1.9, 0.0])
    changed = client.draw(action="change", drawing=drawing["key"], name="two", drone="agent_3", height=1.2)
    assert [changed["drawings"][0][key] for key in ("name", "drone", "height")] == ["two", "agent_3", 1.2]
    assert client.draw(action="undo")["drawings"][0]["name"] == "one"
    assert "saved in" in client.draw(action="save", name="set 1")["text"]
    text = client.get(f"/api/drawings/{drawing['key']}.csv").text
    assert text.splitlines()[0] == "t,x,y,z"
    assert client.draw(action="delete")["drawings"] == []
    loaded = client.draw(action="load", name="set 1")
    assert loaded["drawings"][0]["points"] == drawing["points"]
    assert len(client.draw(action="import", name="again", text=text)["drawings"]) == 2
    assert client.draw(action="import", name="bad", text="0,0,0\n1,x,2\n")["text"].startswith("bad, line 2: y is 'x'")
    assert client.draw(action="load", name="other")["text"] == "nothing is saved as 'other', but: set 1"


def test_the_lettering_keeps_its_limits_and_its_distances(client):
    client.draw(action="example", name="lettering")
    preview = client.post("/api/preview", {"time_scale": 3.0}).json()
    assert preview["warnings"] == []
    assert len(preview["parts"]) == 4
    assert max(max(part["speed"]) for part in preview["parts"]) <= 1.0 + 1e-3
    dry = client.post("/api/dry_run", {"preview": preview["key"]}).json()
    assert max(part["rms"] for part in dry["parts"]) < 0.05


def test_what_is_too_fast_is_marked_and_said(client):
    client.draw(action="delete")
    client.draw(action="add", points=[[2.0 * k, 0.5 * (k % 2), 0.5 * k] for k in range(6)])
    hasty = client.post("/api/preview", {"time_scale": 0.5, "stretch": False}).json()
    assert any("speed is" in text and "allowed: 1.00" in text for text in hasty["warnings"])
    assert hasty["parts"][0]["violations"]["speed"]
    patient = client.post("/api/preview", {"time_scale": 0.5}).json()
    assert patient["warnings"] == []
    assert patient["parts"][0]["slowdown"] > 1.5
    assert patient["parts"][0]["violations"] == {"speed": [], "acceleration": []}


def test_two_drawings_for_one_drone_are_refused(client):
    client.draw(action="delete")
    for _ in range(2):
        key = client.draw(action="add", points=LINE)["drawings"][-1]["key"]
        client.draw(action="change", drawing=key, drone="agent_0")
    assert client.post("/api/preview", {}).json()["text"].startswith("agent_0 has 2 drawings, allowed: one")


# ---------------------------------------------------------------- hostile input

WORDS = ["takeoff", "land", "stop", "start", "goto", "arm", "reboot", "set_parameter", "speed", "rewind", "fly", "quit"]
JSON = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.floats()
    | st.text(max_size=20)
    | st.sampled_from(["agent_0", *WORDS]),
    lambda inner: st.lists(inner, max_size=4) | st.dictionaries(st.text(max_size=8), inner, max_size=4),
    max_leaves=12,
)
KEYS = ("drones", "x", "y", "z", "duration", "armed", "parameter", "value", "factor", "branch", "time", "preview")
COMMANDS = st.fixed_dictionaries(
    {"name": st.sampled_from(WORDS)}, optional={key: JSON | st.just(["agent_0"]) for key in KEYS}
)
ENVELOPES = st.fixed_dictionaries({"id": st.uuids().map(lambda one: one.hex), "command": COMMANDS | JSON})


@given(body=ENVELOPES | JSON, path=st.sampled_from(["command", "drawings", "preview", "dry_run"]))
@settings(max_examples=80)
def test_whatever_is_sent_gets_an_answer(client, session, body, path):
    if isinstance(body, dict) and path == "drawings" and "command" in body:
        body = {"id": body["id"], "change": body["command"]}
    text = json.dumps(body)
    headers = {"content-type": "application/json"}
    answer = client.request("POST", f"/api/{path}", content=text, headers=headers)
    assert answer.status_code in (200, 409, 422), answer.text
    assert answer.json()["ok"] is (answer.status_code == 200)
    assert answer.status_code == 200 or len(answer.json()["text"]) > 10
    assert session.error is None
    if session.speed:  # one of them was good
        session.speed = 0.0


@given(
    body=st.binary(max_size=200), kind=st.sampled_from(["application/json", "text/plain", "", "multipart/form-data"])
)
@settings(max_examples=40)
def test_bytes_get_an_answer(client, body, kind):
    answer = client.request("POST", "/api/command", content=body, headers={"content-type": kind})
    assert answer.status_code == 422
    assert answer.json()["ok"] is False


@given(wish=JSON | st.fixed_dictionaries({"watch": st.lists(st.tuples(JSON, JSON).map(list) | JSON, max_size=4)}))
@settings(max_examples=60)
def test_wishes_of_browsers_are_harmless(session, wish):
    from crazychoir_fw.gui.live import _Browser

    browser = _Browser(None, session)
    browser._take(wish)
    for drone, name in session.watched.pop(browser, ()):
        assert 0 <= drone < 4
        assert isinstance(name, str)


@pytest.mark.parametrize("deep", ["[" * 100_000, '{"id":' * 50_000])
def test_deep_nesting_is_refused(client, deep):
    answer = client.request("POST", "/api/command", content=deep, headers={"content-type": "application/json"})
    assert answer.status_code == 422


@pytest.mark.parametrize(
    ("data", "sentence"),
    [
        ({"id": "a"}, "command: Field required"),
        ({"id": "a", "command": {"name": "explode"}}, "command: Input tag 'explode'"),
        ({"id": "a", "command": {"name": "speed", "factor": True}}, "must be a number"),
        ({"id": "a", "command": {"name": "goto", "x": 1e9, "y": 0, "z": 1}}, "less than or equal to 100"),
        ({"id": "a", "command": {"name": "takeoff", "drones": []}}, "at least 1 item"),
        ({"id": "a" * 100, "command": {"name": "stop"}}, "at most 64 characters"),
        ({"id": "a", "command": {"name": "stop", "extra": 1}}, "Extra inputs are not permitted"),
    ],
)
def test_refusals_name_the_place(data, sentence):
    from crazychoir_fw.common.errors import RangeError

    with pytest.raises(RangeError) as refused:
        read(Envelope, data)
    assert sentence in str(refused.value)


def test_numbers_of_a_preview_have_ranges():
    from crazychoir_fw.common.errors import RangeError

    with pytest.raises(RangeError, match="distance"):
        read(PreviewRequest, {"distance": float("nan")})


# ---------------------------------------------------------------- access


@pytest.mark.parametrize(
    ("headers", "status"),
    [
        ({}, 200),
        ({"origin": "http://localhost"}, 200),
        ({"origin": "http://elsewhere.example"}, 403),
        ({"origin": "null"}, 403),
        ({"host": "rebound.example"}, 403),
        ({"content-length": "99999999"}, 413),
    ],
)
def test_other_pages_are_refused(client, headers, status):
    assert client.get("/api/drawings", headers=headers).status_code == status


def test_the_token_is_asked_for(session, api, tmp_path):
    client = api(session, tmp_path, token="open sesame", host="192.0.2.1")
    assert client.get("/api/drawings").status_code == 401
    assert client.get("/api/drawings?token=open+sesam").status_code == 401
    first = client.get("/api/drawings?token=open+sesame")
    assert first.status_code == 200
    assert "HttpOnly" in first.headers["set-cookie"]
    bearer = {"authorization": "Bearer open sesame"}
    assert client.get("/api/drawings", headers=bearer).status_code == 200


@pytest.mark.parametrize(
    ("host", "is_real", "is_made"),
    [("0.0.0.0", False, True), ("192.0.2.1", False, True), ("127.0.0.1", True, True), ("127.0.0.1", False, False)],
)
def test_a_token_is_made_for_other_hosts_and_for_real_drones(host, is_real, is_made):
    made = [token_for(host, is_real, None) for _ in range(2)]
    if is_made:
        assert made[0] != made[1]
        assert min(map(len, made)) >= 16
    else:
        assert made == [None, None]
    assert token_for(host, is_real, "long-enough") == "long-enough"


@pytest.mark.parametrize("token", ["short", "with a space", "half;half", "schl\u00fcssel", "x" * 201, "new\nline-x"])
def test_tokens_that_a_link_or_a_cookie_cannot_hold_are_refused(token):
    with pytest.raises(RangeError, match="--token must be 8 to 200 letters, digits"):
        token_for("127.0.0.1", False, token)


def test_a_body_in_chunks_is_counted(client):
    async def endless():
        for _ in range(1000):
            yield bytes(100_000)

    answer = client.request("POST", "/api/command", content=endless(), headers={"content-type": "application/json"})
    assert answer.status_code == 413


def test_no_answer_may_be_shown_in_a_frame(client):
    for answer in (client.get("/api/setting"), client.get("/api/drawings", headers={"origin": "http://elsewhere"})):
        assert answer.headers["x-frame-options"] == "DENY"
        assert "frame-ancestors 'none'" in answer.headers["content-security-policy"]
