"""Make the pictures of docs/gui.md: a mission is flown on the page by a browser, and every tab is looked at.

    python docs/make_gui_pictures.py [--out docs/images/gui]

Needs Chromium (`--chromium`) and `pip install crazychoir-fw[gui] playwright`.
"""

import argparse
import contextlib
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import sync_playwright

HERE = Path(__file__).parent
PORT = 8479
READY = (
    "window.cc && cc.frame && cc.setting && cc.words.cards"
    " && document.querySelector('.cc-status').textContent.includes('real time')"
)
ARGUMENTS = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]


@contextlib.contextmanager
def page_of(mission, folder, *options):
    """Run `crazychoir gui` for as long as it is needed."""
    command = [sys.executable, "-c", "from crazychoir_fw.cli import app; app()", "gui", str(mission)]
    command += ["--no-browser", "--port", str(PORT), "--drawings", str(folder), *options]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    try:
        for line in process.stdout:
            if "http://" in line:
                break
        yield f"http://127.0.0.1:{PORT}/"
    finally:
        process.terminate()
        process.wait(timeout=30)


def show(page, tab):
    """Choose a tab."""
    page.locator(".q-tab", has_text=tab).click()
    page.mouse.move(640, 30)
    time.sleep(1.2)


def quiet(page):
    """Leave no message over the picture."""
    page.evaluate("document.getElementById('cc-toasts').replaceChildren()")


def take(browser, address, out):
    """Fly the lettering, and look at every tab."""
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(180_000)
    page.on("pageerror", lambda error: print("error on the page:", error))
    page.goto(address)
    page.wait_for_function(READY)
    show(page, "Draw")
    page.get_by_text("EXAMPLE: LETTERING").click()
    time.sleep(0.6)
    page.get_by_label("Show all").locator("visible=true").click()
    time.sleep(0.3)
    quiet(page)
    page.screenshot(path=out / "draw.png")
    show(page, "Preview")
    page.evaluate("document.activeElement.blur()")
    page.wait_for_selector("[data-testid=preview-facts]")
    page.get_by_text("DRY RUN").click()
    page.mouse.move(640, 30)
    page.wait_for_selector("[data-testid=dry]", timeout=240000)
    quiet(page)
    page.screenshot(path=out / "preview.png")
    page.get_by_text("FLY", exact=True).click()
    page.wait_for_function("cc.words.flying && cc.words.flying.phase === 'curves'", timeout=240000)
    show(page, "Watch")
    page.get_by_label("Show all drones").locator("visible=true").click()
    page.wait_for_function("cc.frame.time > cc.words.flying.started + 8", timeout=240000)
    quiet(page)
    page.screenshot(path=out / "watch.png")
    show(page, "Fly")
    # with most of the cards
    page.set_viewport_size({"width": 1280, "height": 900})
    time.sleep(1.0)
    quiet(page)
    page.screenshot(path=out / "fly.png")
    page.set_viewport_size({"width": 1280, "height": 800})
    page.wait_for_function("cc.words.flying === null", timeout=240000)
    show(page, "Rewind")
    begin = page.evaluate("cc.frame.time")
    page.evaluate(f"cc.command({{ name: 'rewind', branch: 0, time: {begin - 6} }})")
    page.wait_for_function("cc.words.branches.length === 2")
    page.evaluate("cc.command({ name: 'goto', drones: ['agent_0', 'agent_3'], x: 0, y: 1.2, z: 1.5 })")
    time.sleep(3.0)
    page.locator("[data-testid=branch] .q-toggle").first.click()
    time.sleep(1.0)
    quiet(page)
    page.screenshot(path=out / "rewind.png")
    show(page, "Parameters")
    page.get_by_label("Search, for instance: pid kp").fill("posCtl kp")
    time.sleep(0.5)
    page.screenshot(path=out / "parameters.png")
    show(page, "Console")
    page.screenshot(path=out / "console.png")
    # dark, on a phone, on a projector
    page.get_by_label("Light or dark").click()
    show(page, "Watch")
    quiet(page)
    page.screenshot(path=out / "dark.png")
    page.close()
    phone = browser.new_page(viewport={"width": 390, "height": 780}, device_scale_factor=1.5, has_touch=True)
    phone.set_default_timeout(180_000)
    phone.goto(address)
    phone.wait_for_function(READY)
    time.sleep(1.5)
    phone.screenshot(path=out / "phone.png")
    phone.close()
    projector = browser.new_page(viewport={"width": 1920, "height": 1080})
    projector.goto(address)
    projector.wait_for_function(READY)
    time.sleep(1.5)
    projector.screenshot(path=out / "projector.png")
    projector.close()


def main():
    """Make all pictures."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=HERE / "images" / "gui")
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--mission", type=Path, default=HERE.parent / "examples" / "draw.yaml")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    folder = arguments.out.parent / "no such folder"  # nothing is saved
    with page_of(arguments.mission, folder, "--speed", "2") as address, sync_playwright() as driver:
        browser = driver.chromium.launch(executable_path=arguments.chromium, args=ARGUMENTS)
        take(browser, address, arguments.out)
        browser.close()


if __name__ == "__main__":
    main()
