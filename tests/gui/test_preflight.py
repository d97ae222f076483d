"""The list of checks before take-off."""

import time

import numpy as np
import pytest

from crazychoir_fw.gui.preflight import preflight


@pytest.fixture
def checks(open_flight):
    session = open_flight("draw.yaml")

    def look(change=lambda world: None):
        def act():
            world = session.experiment.backend.world
            change(world)
            return {check["name"]: check for check in preflight(session)}

        return session.ask(act).result()

    return look


def bad(found):
    return {name: check["text"] for name, check in found.items() if not check["ok"]}


def test_drones_that_are_ready_pass_all_checks(checks):
    found = checks()
    assert bad(found) == {}
    assert list(found) == ["drones", "batteries", "estimators", "positions", "starts", "distances"]
    assert found["distances"]["text"] == "1.00 m or more"


def test_each_check_names_what_is_wrong(checks):
    def put_beside(world):
        world.drones[1].place((-1.5, -1.3, 0.01))  # agent_0 stands at (-1.5, -1.5)

    found = bad(checks(put_beside))
    assert found["starts"] == "agent_1 stands 1.02 m from its start"
    assert found["distances"] == "agent_0 and agent_1 are 0.20 m apart"
    assert "agent_1 is off by 102 cm" in found["estimators"]


def test_a_low_battery_is_no_battery_to_fly_with(checks, monkeypatch):
    from crazychoir_fw.flight.access.sim import SimAccess

    monkeypatch.setattr(SimAccess, "batteries", lambda self: np.array([4.1, 3.62, 4.0, 4.2]))
    assert bad(checks()) == {"batteries": "agent_1 has 3.62 V"}


def test_the_page_asks_back_and_says_why(open_flight, serve, browser, tmp_path):
    session = open_flight("draw.yaml", speed=1.0)
    session.ask(lambda: session.experiment.backend.world.drones[1].place((-1.5, -1.3, 0.01))).result()
    page = browser.new_page()
    page.set_default_timeout(60_000)
    page.goto(serve(session, tmp_path).address)
    page.get_by_test_id("preflight").get_by_text("Not ready").wait_for()
    page.get_by_role("button", name="MISSION").click()
    asking = page.get_by_test_id("preflight-ask")
    asking.get_by_text("agent_1 stands 1.02 m from its start").wait_for()
    assert session.flying is None
    asking.get_by_role("button", name="STAY").click()
    time.sleep(0.3)
    assert session.flying is None
    page.close()
