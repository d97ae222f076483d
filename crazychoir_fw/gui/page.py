"""The page: a head with STOP that is there on every tab, and one tab for each thing that people do."""

from __future__ import annotations

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
"""
_TOASTS = '<div id="cc-toasts" aria-live="assertive"></div>'


def mount(app: Any, session: Session) -> None:
    """Add the page to an application; NiceGUI knows one per process."""

    @ui.page("/", title=f"{session.mission.name} - crazychoir")
    def page() -> None:
        build(session)

    nicegui_app.add_static_files("/static", _STATIC)
    # what a browser has missed for so long it asks for anew; the flight does not care
    ui.run_with(app, title="crazychoir", dark=None, reconnect_timeout=30.0, show_welcome_message=False)


def build(session: Session) -> None:
    """Build the page for one browser."""
    ui.add_head_html(_HEAD)
    ui.add_body_html(_TOASTS)
    names = [name for name, _ in TABS]
    with ui.header(elevated=False).classes("cc-head"):
        ui.label(session.mission.name).classes("cc-title")
        ui.label("The drones get ready").classes("cc-status").props('role="status"')
        ui.button(icon="contrast").props('flat round dense color=grey aria-label="Light or dark"').on(
            "click", js_handler="() => cc.toggleDark()"
        )
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
            _two(lambda: parts.SwarmMap("goto"), parts.FlyButtons).classes("cc-with-cards")
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
    ui.run_javascript(
        f"cc.beginHead(); cc.tabs = {names!r}; cc.on('tab', (k) => document.querySelectorAll('.q-tab')[k]?.click());"
    )


def _two(left: Any, right: Any) -> ui.element:
    """A picture, and what belongs to it beside or, on a phone, below it."""
    with ui.element("div").classes("cc-two") as both:
        with ui.element("div").classes("cc-left"):
            left()
        with ui.element("div"):
            right()
    return both
