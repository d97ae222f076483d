"""Flights of real Crazyflies that somebody recorded, and what our software makes of the same inputs.

`read_flight` and `read_folder` read the NanoBench format. Four comparisons, from the one that depends least on the
plant to the one that depends on everything: `controller_replay`, `motor_replay`, `prediction`, `whole_chain`.
"""

from recorded.nanobench import RecordedFlight, flight_files, read_flight

__all__ = ["RecordedFlight", "flight_files", "read_flight"]
