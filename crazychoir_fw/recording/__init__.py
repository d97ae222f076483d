"""What remains of a flight: the log, its plot and its film."""

from crazychoir_fw.recording.flight_log import FlightLog

__all__ = ["FlightLog"]
