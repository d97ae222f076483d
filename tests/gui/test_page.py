"""The page in a browser, with four drones in MuJoCo: actions of a user, and their visible effects."""

import re
import threading
from functools import partial
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer

import numpy as np
import pytest
from playwright.sync_api import expect
from scipy.spatial.transform import Rotation

from crazychoir_fw.flight.agent import DronePhase

expect.set_options(timeout=60_000)

RADIUS = 0.35
CENTERS = [(-1.5, 0.3), (-0.5, 0.3), (0.5, 0.3), (1.5, 0.3)]


@pytest.fixture(scope="module")
def session(open_flight):
    return open_flight("draw.yaml", speed=0.0)


@pytest.fixture(scope="module")
def address(session, serve, tmp_path_factory):
    return serve(session, tmp_path_factory.mktemp("drawings")).address


@pytest.fixture
def open_page(browser, address):
    errors, pages = [], []

    def open_one(**options):
        page = browser.new_page(viewport={"width": 1200, "height": 800}, **options)
        page.set_default_timeout(90_000)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.goto(address)
        page.wait_for_function("window.cc && cc.frame && cc.setting && cc.words.cards")
        pages.append(page)
        return page

    yield open_one
    for page in pages:
        page.close()
    assert errors == []


@pytest.fixture(autouse=True)
def on_the_floor(session):
    """Every test begins with drones that stand, as they were when the page was opened."""
    first = session.branches.all[min(session.branches.all)]
    yield
    session.speed = 0.0
    if first.moments:
        session.ask(lambda: session.go_back(first.number, 0.0)).result(30.0)


def tab(page, name):
    page.locator(".q-tab", has_text=name).click()


def circle(center, turns=0.8, count=14):
    angle = np.linspace(0.0, 2.0 * np.pi * turns, count)
    return np.stack([center[0] + RADIUS * np.cos(angle), center[1] + RADIUS * np.sin(angle)], axis=1)


def draw(page, points):
    """Draw on the canvas with the mouse."""
    canvas = page.get_by_test_id("map-draw")
    view = {key: float(canvas.get_attribute(f"data-{key}")) for key in ("x", "y", "scale")}
    box = canvas.bounding_box()
    pixels = [
        (
            box["x"] + box["width"] / 2 + (x - view["x"]) * view["scale"],
            box["y"] + box["height"] / 2 - (y - view["y"]) * view["scale"],
        )
        for x, y in points
    ]
    page.mouse.move(*pixels[0])
    page.mouse.down()
    for pixel in pixels[1:]:
        page.mouse.move(*pixel)
        page.wait_for_timeout(20)  # as a hand: points of one instant make a curve that overshoots
    page.mouse.up()


def test_draw_preview_fly_land(open_page, session, until):
    page = open_page()
    tab(page, "Draw")
    for number, center in enumerate(CENTERS):
        draw(page, circle(center))
        expect(page.get_by_test_id("drawing")).to_have_count(number + 1)
    drawn = page.evaluate("cc.drawings.drawings")
    for drawing, center in zip(drawn, CENTERS, strict=True):
        wanted, points = circle(center), np.array(drawing["points"])
        # not mirrored, not rotated, the last sample is there; a pixel is 6 mm
        np.testing.assert_allclose(points[[0, -1]], wanted[[0, -1]], atol=0.01)
        assert np.linalg.norm(points[:, None] - wanted[None], axis=2).min(axis=0).max() < 0.02

    tab(page, "Preview")
    page.wait_for_selector("[data-testid=preview-facts]")
    page.get_by_text("FLY", exact=True).click()
    until(lambda: session.flying is not None)
    flying = session.flying
    session.speed = 20.0
    legs = list(flying.legs)
    assert [leg.drone for leg in legs] == [0, 1, 2, 3]
    until(lambda: session.flying is None, 120.0)
    page.evaluate("cc.press('land', null)")
    until(lambda: all(agent.phase is DronePhase.LANDED for agent in session.experiment.agents), 120.0)

    times = np.array(session.branches.present.times)
    paths = np.array([sample.position for sample in session.branches.present.samples])
    on_curve = (times >= flying.started) & (times <= flying.started + flying.duration)
    for leg, center in zip(legs, CENTERS, strict=True):
        flown = paths[on_curve, leg.drone]
        at = np.clip(times[on_curve] - flying.started, 0.0, leg.curve.duration)
        errors = np.linalg.norm(flown - leg.curve.position(at)[:, :3], axis=1)
        assert np.sqrt((errors**2).mean()) < 0.1
        # and against what the hand has drawn
        beside = np.linalg.norm(flown[:, None, :2] - circle(center, count=200)[None], axis=2).min(axis=1)
        assert np.sqrt((beside**2).mean()) < 0.1


@pytest.mark.parametrize("how", ["button", "key"])
def test_stop_in_flight(open_page, session, until, how):
    page = open_page()
    session.speed = 5.0
    page.get_by_text("TAKE-OFF", exact=True).click()
    until(lambda: session.frame.position[:, 2].min() > 0.3)
    tab(page, "Console" if how == "button" else "Parameters")
    if how == "button":
        page.get_by_test_id("stop").click()
    else:
        page.get_by_label("Search, for instance: pid kp").click()  # also while the focus is in a text field
        page.keyboard.press("Escape")
    until(lambda: not any(agent.is_up for agent in session.experiment.agents))
    until(lambda: session.frame.position[:, 2].max() < 0.1)
    assert sum(line.text.startswith("STOP") for line in session.lines if line.number > 0) >= 1


def test_parameters_are_found_and_written(open_page, session):
    page = open_page()
    tab(page, "Parameters")
    page.get_by_label("Search, for instance: pid kp").fill("posctl xkp")
    cell = page.get_by_label("posCtlPid.xKp")
    cell.fill("1.25")
    cell.press("Enter")
    drones = session.experiment.backend.world.drones
    page.wait_for_function("cc.lines.some((line) => line.text.includes('posCtlPid.xKp = 1.25'))")
    assert drones[0].param["posCtlPid.xKp"] == 1.25
    assert drones[1].param["posCtlPid.xKp"] != 1.25
    cell.fill("much")
    cell.press("Enter")
    expect(page.get_by_role("alert").filter(has_text="'much', allowed: a number")).to_be_visible()
    assert drones[0].param["posCtlPid.xKp"] == 1.25


def test_rewind_changes_the_future_and_keeps_the_past(open_page, session, until):
    page = open_page()
    page.get_by_text("TAKE-OFF", exact=True).click()
    # time stands still whenever the page is asked something: slow browsers miss none of it
    until(lambda: all(agent.is_up for agent in session.experiment.agents))
    begin = session.frame.time
    session.speed = 10.0
    until(lambda: session.frame.time > begin + 6.0)
    old = session.branches.present
    tab(page, "Rewind")
    page.evaluate("cc.command({ name: 'speed', factor: 0 })")
    until(lambda: session.is_paused)
    count = len(session.branches.all)
    # moments are the fewer, the slower the machine
    moment = next(moment.time for moment in old.moments if moment.time > begin + 1.0)
    page.evaluate(f"cc.command({{ name: 'rewind', branch: {old.number}, time: {moment + 0.01} }})")
    expect(page.get_by_test_id("branch")).to_have_count(min(count + 1, 8))
    until(lambda: session.frame.time == moment)
    page.evaluate("cc.command({ name: 'goto', drones: ['agent_0'], x: -1.5, y: 0.5, z: 0.8, duration: 3 })")
    session.speed = 10.0
    until(lambda: session.frame.time > moment + 5.5)
    assert session.branches.present is not old
    assert abs(session.frame.position[0, 1] - 0.5) < 0.15
    assert abs(old.samples[-1].position[0, 1] + 1.5) < 0.1


def test_two_browsers_and_a_reload_in_flight(open_page, session, until):
    first, second = open_page(), open_page()
    session.speed = 2.0
    first.get_by_text("TAKE-OFF", exact=True).click()
    second.wait_for_function("cc.frame.drones.every((drone) => drone.phase === 'flying')")
    until(lambda: session.frame.position[:, 2].min() > 0.2)
    second.evaluate("cc.draw({ action: 'delete' }, true)")
    first.wait_for_function("cc.drawings.drawings.length === 0")
    before = session.frame.time
    first.reload()
    first.wait_for_function("window.cc && cc.frame && cc.setting && cc.words.cards")
    assert session.frame.time > before
    assert all(agent.is_up for agent in session.experiment.agents)
    # trails are there at once, and what was said before
    assert first.evaluate("cc.trails.length") > 5
    assert first.evaluate("cc.lines.filter((line) => line.text.startsWith('TAKE-OFF')).length") >= 1
    taken_off = sum(happening.kind == "takeoff" for happening in session.experiment.events)
    assert taken_off == 4, "each drone was told once"


def test_an_answer_that_got_lost_does_not_fly_twice(open_page, session, until):
    page = open_page()
    session.speed = 2.0
    lost = []

    def lose_the_first(route):
        if lost:
            route.continue_()
            return
        lost.append(route.fetch())  # carried out, but the browser gets no response
        route.abort()

    page.route("**/api/command", lose_the_first)
    page.get_by_text("TAKE-OFF", exact=True).click()
    expect(page.get_by_role("status").filter(has_text="TAKE-OFF: all 4 drones")).to_be_visible()
    assert len(lost) == 1
    until(lambda: session.frame.time > 0.0)
    assert sum(happening.kind == "takeoff" for happening in session.experiment.events) == 4


def test_cards_show_attitude_and_motors(open_page, session, until):
    """Positive roll is to the right, positive pitch nose up, as in stateEstimate."""
    page = open_page()
    session.speed = 5.0
    page.evaluate("cc.press('takeoff', null)")
    until(lambda: session.frame.position[:, 2].min() > 0.8)
    dial = """(quat) => {
      if (quat) cc.frame.drones[0].quat = quat;
      cc.emit("selection");
      const label = () => document.querySelector(".cc-dial").getAttribute("aria-label");
      return new Promise((tell) => setTimeout(() => tell(label())));
    }"""
    for roll, pitch in [(0, 0), (30, 0), (0, 20), (-15, -40)]:
        quat = Rotation.from_euler("ZYX", [50, -pitch, roll], degrees=True).as_quat().tolist()
        assert page.evaluate(dial, quat).startswith(f"roll {roll}, pitch {pitch} deg, motors ")
    until(lambda: all(40 < int(duty) < 90 for duty in re.findall(r"[0-9]+", page.evaluate(dial).split("motors")[1])))


def test_plots_show_values_and_the_camera_follows(open_page, session, until):
    page = open_page()
    tab(page, "Watch")
    view = "getElement(Number(document.querySelector('.q-tab-panel .cc-view').id.slice(1)))"
    target = f"{view}.three.controls.target.toArray()"
    page.locator(".cc-view:visible").get_by_text("follow").click()
    before = page.evaluate(target)
    session.speed = 5.0
    page.evaluate("cc.press('takeoff', null)")
    until(lambda: session.frame.position[:, 2].min() > 0.8)
    until(lambda: page.evaluate(target)[2] > before[2] + 0.5)
    plot = page.locator("[data-variable='stateEstimate.z']")
    box = plot.bounding_box()
    steps = iter(range(10_000))

    def look():
        page.mouse.move(box["x"] + box["width"] / 2 + next(steps) % 9, box["y"] + box["height"] / 2)
        return "agent_3" in plot.inner_text()

    until(look)


def test_the_log_is_downloaded(open_page, session, until):
    page = open_page()
    session.speed = 5.0
    until(lambda: len(session.branches.present.times) > 5)
    tab(page, "Console")
    page.get_by_label("Download the log of the flight").click()
    with page.expect_download() as download:
        page.get_by_test_id("log-csv").click()
    assert download.value.suggested_filename == "draw.csv"
    head, *rows = download.value.path().read_text().splitlines()
    assert head.startswith("time,drone,sim.x,sim.y,sim.z")
    assert len(rows) >= 5 * 4


def test_every_tab_fits_a_phone(open_page):
    page = open_page(has_touch=True)
    page.set_viewport_size({"width": 390, "height": 780})
    for name in ("Fly", "Watch", "Draw", "Preview", "Rewind", "Parameters", "Console"):
        tab(page, name)
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        assert page.get_by_test_id("stop").is_visible()


def test_a_touch_draws(open_page):
    page = open_page(has_touch=True)
    tab(page, "Draw")
    before = page.evaluate("cc.drawings.drawings.length")
    canvas = page.get_by_test_id("map-draw")
    canvas.scroll_into_view_if_needed()
    canvas.evaluate(
        """(canvas) => {
          const box = canvas.getBoundingClientRect();
          const send = (type, k) => canvas.dispatchEvent(new PointerEvent(type, { pointerId: 1, pointerType: "touch",
            isPrimary: true, bubbles: true, clientX: box.left + 200 + 5 * k, clientY: box.top + 200 + 3 * k }));
          canvas.setPointerCapture = () => {};
          send("pointerdown", 0);
          for (let k = 1; k < 40; k++) send("pointermove", k);
          send("pointerup", 40);
        }"""
    )
    page.wait_for_function(f"cc.drawings.drawings.length === {before + 1}")
    page.get_by_role("button", name="UNDO").click()
    page.wait_for_function(f"cc.drawings.drawings.length === {before}")


def test_another_site_cannot_show_the_page_in_a_frame(browser, address, tmp_path):
    """A click that is led to TAKE-OFF through an invisible frame would fly the drones."""
    attack = f'<iframe src="{address}" width="1200" height="800" style="opacity: 0.01"></iframe>'
    (tmp_path / "index.html").write_text(attack)
    with ThreadingHTTPServer(("127.0.0.1", 0), partial(SimpleHTTPRequestHandler, directory=tmp_path)) as site:
        threading.Thread(target=site.serve_forever, daemon=True).start()
        page = browser.new_page()
        page.goto(f"http://127.0.0.1:{site.server_address[1]}/", wait_until="networkidle")
        (frame,) = page.frames[1:]
        assert frame.url.startswith("chrome-error:")
        assert frame.get_by_text("TAKE-OFF").count() == 0
        page.close()
        site.shutdown()
