"""The page: a head with STOP that is there on every tab, and one tab for each task of a user."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nicegui import app as nicegui_app
from nicegui import ui

from crazychoir_fw.gui import components as parts

if TYPE_CHECKING:
    from crazychoir_fw.gui.session import Session

_STATIC = Path(__file__).parent / "static"
TABS = (
    ("Fly", "flight"),
    ("Watch", "visibility"),
    ("Draw", "draw"),
    ("Preview", "show_chart"),
    ("Rewind", "history"),
    ("Parameters", "tune"),
    ("Console", "terminal"),
)

_HEAD = """
<meta name="viewport" content="width=device-width, initial-scale=1">
<link rel="stylesheet" href="/static/page.css">
<script src="/static/crazychoir.js"></script>
<script src="/static/head.js"></script>
<script src="/static/attitude_dial.js"></script>
"""
_TOASTS = '<div id="cc-toasts" aria-live="assertive"></div>'


def mount(app: Any, session: Session) -> None:
    """Add the page to an application; NiceGUI knows one per process at a time."""
    _mount(app, session.mission.name, lambda: build(session.mission.name))


def mount_view(app: Any, title: str) -> None:
    """Add a page to look at to an application."""
    _mount(app, title, lambda: build_view(title))


def _mount(app: Any, title: str, build_one: Callable[[], None]) -> None:
    ui.page("/", title=f"{title} - crazychoir")(build_one)
    nicegui_app.add_static_files("/static", _STATIC)
    nicegui_app.middleware_stack = None  # that of a page which this process had before
    # a browser that reconnects later than this reloads the page; the flight does not depend on it
    ui.run_with(app, title="crazychoir", dark=None, reconnect_timeout=30.0, show_welcome_message=False)


@contextmanager
def _head(title: str) -> Iterator[None]:
    """Build the head of a page, and let more be put into it."""
    ui.add_head_html(_HEAD)
    ui.add_body_html(_TOASTS)
    with ui.header(elevated=False).classes("cc-head"):
        ui.label(title).classes("cc-title")
        ui.label("The drones get ready").classes("cc-status").props('role="status"')
        ui.button(icon="contrast").props('flat round dense color=grey aria-label="Light or dark"').on(
            "click", js_handler="() => cc.toggleDark()"
        )
        yield
    ui.run_javascript("cc.beginHead();")


def build_view(title: str) -> None:
    """Build a page to look at for one browser."""
    with _head(title):
        pass
    with ui.element("div").classes("cc-only"):
        parts.SwarmView()


def build(title: str) -> None:
    """Build the page for one browser."""
    names = [name for name, _ in TABS]
    with _head(title):
        ui.button("STOP", icon="dangerous").props(
            'color=negative unelevated aria-label="Stop all motors at once" data-testid="stop"'
        ).classes("cc-stop").on("click", js_handler="() => cc.stop()").tooltip("All motors off at once. Key: Esc")
    with (
        ui.tabs().props("dense no-caps inline-label outside-arrows mobile-arrows align=left").classes("w-full") as tabs
    ):
        for name, icon in TABS:
            ui.tab(name, icon=icon)
    tabs.on("update:model-value", js_handler="(tab) => setTimeout(() => cc.emit('shown', tab), 400)")
    with ui.tab_panels(tabs, value="Fly", animated=False).props("keep-alive"):
        with ui.tab_panel("Fly"):
            _two(lambda: parts.SwarmMap("goto"), lambda: (parts.FlyButtons(), parts.PreflightList())).classes(
                "cc-with-cards"
            )
            ui.element("div").style("height: 0.6rem")
            parts.DroneCards()
        with ui.tab_panel("Watch"):
            _two(parts.SwarmView, parts.LivePlots)
        with ui.tab_panel("Draw"):
            _two(lambda: parts.SwarmMap("draw"), parts.DrawingList)
        with ui.tab_panel("Preview"):
            parts.PreviewPanel()
        with ui.tab_panel("Rewind"):
            _two(lambda: parts.SwarmView(), parts.TimeLine)
        with ui.tab_panel("Parameters"):
            parts.ParameterTable()
        with ui.tab_panel("Console"):
            parts.ConsoleLog()
    ui.run_javascript(f"cc.tabs = {names!r}; cc.on('tab', (k) => document.querySelectorAll('.q-tab')[k]?.click());")


def _two(left: Any, right: Any) -> ui.element:
    """A picture, and what belongs to it beside or, on a phone, below it."""
    with ui.element("div").classes("cc-two") as both:
        with ui.element("div").classes("cc-left"):
            left()
        with ui.element("div"):
            right()
    return both
