"""What remains of a flight: the log, its plot and its film."""

from crazychoir_fw.report.flight_log import FlightLog

__all__ = ["FlightLog"]
