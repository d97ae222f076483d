"""Make the pictures of docs/viewer.md: `python docs/make_viewer_pictures.py`.

The picture of the window needs Xvfb, that of the page NiceGUI, playwright and Chromium; what is missing stays as it is.
"""

import os
import queue
import shutil
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.cli.view import open_view
from crazychoir_fw.flight.engine import Progress
from crazychoir_fw.simulation import DroneConfig, World

IMAGES = Path(__file__).parent / "images"
PLACES = ((0.0, 0.0), (0.7, 0.25), (0.5, -0.5), (-0.4, -0.5))


def fly(show=None, seconds: float = 3.2, hold_s: float = 0.0) -> World:
    """Fly four drones through the lab, with or without somebody who watches; returns their world in flight."""
    drones = [DroneConfig(f"cf{k}", place) for k, place in enumerate(PLACES, start=1)]
    world = World(drones, scene="flight_lab", seed=1)
    world.wait_until_ready()
    start = world.time
    for k, drone in enumerate(world.drones):
        drone.high_level_commander.takeoff(absolute_height_m=0.7 + 0.15 * k, duration_s=1.5)
    is_sent = False
    while world.time - start < seconds:
        if not is_sent and world.time - start >= 2.0:
            is_sent = True
            for k, (drone, place) in enumerate(zip(world.drones, PLACES, strict=True)):
                height = 0.7 + 0.15 * k
                drone.high_level_commander.go_to(place[0] + 0.6, place[1] + 0.4, height, yaw=0.0, duration_s=2.0)
        world.step(10)
        if show is not None:
            show(world, Progress(world.time - start, seconds, 0.0))
    time.sleep(hold_s)
    return world


def save(name: str, picture: NDArray[np.uint8]) -> None:
    """Write a small PNG."""
    from PIL import Image

    Image.fromarray(picture).save(IMAGES / name, optimize=True)
    print(f"{name}: {(IMAGES / name).stat().st_size / 1000:.0f} kB")


def picture_of_cameras() -> None:
    """Draw what the cameras of one drone see, side by side: picture, depth, geoms, and from behind."""
    world = fly()
    onboard = world["cf1"].camera("fpv", 324, 244)
    near = np.clip(1.0 - onboard.depth() / 4.5, 0.0, 1.0)
    depth = np.repeat((255 * near).astype(np.uint8)[..., None], 3, axis=2)
    hues = np.random.default_rng(2).integers(60, 250, (world.model.ngeom + 1, 3), dtype=np.uint8)
    geoms = hues[onboard.segmentation()]
    chase = world["cf1"].camera("chase", 324, 244).image()
    save("cameras.png", np.hstack([onboard.image(), depth, geoms, chase]))
    save("overlays.png", world.render(800, 450, overlays=True))


def picture_of_window() -> None:
    """Take a picture of MuJoCo's window, on a screen that nobody sees. Runs in a process of its own."""
    from PIL import ImageGrab

    taken = []

    def grab(world: World, progress: Progress) -> None:
        show(world, progress)
        if progress.sim_seconds >= 3.15 and not taken:
            taken.append(np.array(ImageGrab.grab(xdisplay=os.environ["DISPLAY"]))[:533, :853])

    with open_view("native", print) as show:
        fly(grab)
    save("window.png", taken[0])


def picture_of_page() -> None:
    """Take a picture of the page in a Chromium without a screen."""
    from playwright.sync_api import sync_playwright

    from crazychoir_fw.cli.view_web import open_page

    told: queue.Queue[str] = queue.Queue()
    is_open, is_over = threading.Event(), threading.Event()

    def browse() -> None:
        with sync_playwright() as driver:
            options = ["--no-sandbox", "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
            browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=options)
            page = browser.new_page(viewport={"width": 900, "height": 560})
            page.goto(told.get())
            page.wait_for_function("window.cc && cc.frame && cc.setting", timeout=60_000)
            is_open.set()
            is_over.wait()
            time.sleep(4.0)  # a page without a graphics card is slow
            page.screenshot(path=IMAGES / "page.png")

    thread = threading.Thread(target=browse)
    thread.start()
    with open_page(lambda line: told.put(line.split()[2])) as show:

        def watched(world: World, progress: Progress) -> None:
            show(world, progress)
            is_open.wait()

        fly(watched)
        is_over.set()
        thread.join()


if __name__ == "__main__":
    if sys.argv[1:] == ["window"]:
        picture_of_window()
        sys.exit()
    picture_of_cameras()
    if shutil.which("xvfb-run"):
        screen = ["xvfb-run", "-a", "-s", "-screen 0 1280x800x24"]
        subprocess.run([*screen, sys.executable, __file__, "window"], check=True)
    if shutil.which("chromium"):
        picture_of_page()
