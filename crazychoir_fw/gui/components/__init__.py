"""The parts of the page that the browser draws: one Vue component a file, each an element of NiceGUI.

They talk to the server through `static/crazychoir.js` alone, so that they live on when the page reconnects.
"""

# NiceGUI serves ECharts and three.js to pages that may have charts and scenes
import nicegui.elements.echart
import nicegui.elements.scene  # noqa: F401
from nicegui.element import Element


class SwarmMap(Element, component="swarm_map.js"):
    """The room from above; `mode` is ``goto`` or ``draw``."""

    def __init__(self, mode: str = "goto") -> None:
        super().__init__()
        self._props["mode"] = mode


class SwarmView(Element, component="swarm_view.js"):
    """The room in three dimensions."""


class FlyButtons(Element, component="fly_buttons.js"):
    """TAKE-OFF, LAND, START, STOP, arm, reboot."""


class PreflightList(Element, component="preflight_list.js"):
    """What to look at before take-off."""


class DroneCards(Element, component="drone_cards.js"):
    """A card for each drone."""


class DrawingList(Element, component="drawing_list.js"):
    """The drawings, and files of them."""


class PreviewPanel(Element, component="preview_panel.js"):
    """From drawings to curves, and FLY."""


class LivePlots(Element, component="live_plots.js"):
    """Plots of log variables."""


class ParameterTable(Element, component="parameter_table.js"):
    """Parameters on board."""


class ConsoleLog(Element, component="console_log.js"):
    """What happened."""


class TimeLine(Element, component="time_line.js"):
    """Moments to go back to, and branches."""
