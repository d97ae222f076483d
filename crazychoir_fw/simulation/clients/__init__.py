"""The client side of one drone, with cflib's vocabulary: commander, high-level commander, localization, variables.

Scripts written for a real Crazyflie read the same here. Commands take effect at the next tick.
"""

from crazychoir_fw.simulation.clients.commander import Commander
from crazychoir_fw.simulation.clients.high_level_commander import HighLevelCommander
from crazychoir_fw.simulation.clients.localization import Localization
from crazychoir_fw.simulation.clients.uplink import Uplink
from crazychoir_fw.simulation.clients.variables import Log, Param, UpdateCallback

__all__ = ["Commander", "HighLevelCommander", "Localization", "Log", "Param", "UpdateCallback", "Uplink"]
