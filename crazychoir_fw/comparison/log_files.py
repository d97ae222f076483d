"""Reads a log of any known format."""

from __future__ import annotations

from pathlib import Path

from crazychoir_fw.common.errors import RangeError, UnknownNameError
from crazychoir_fw.comparison import csv_log
from crazychoir_fw.comparison.raw_log import RawLog
from crazychoir_fw.comparison.usd_log import MAGIC

FORMATS = "CSV (.csv, .csv.gz), NPZ, MCAP, a rosbag2 folder, the binary log of a micro SD card"


def read_log(path: str | Path, drone: str | None = None) -> RawLog:
    """Return what a log holds; the format is seen from the file.

    Args:
        path: The file; a folder of rosbag2, or one with a `log.npz`.
        drone: Whose columns, where a log has several drones; None takes the first.

    Raises:
        UnknownNameError: If there is no such file.
        RangeError: If it is none of the formats, or damaged; one sentence.
        MissingLibraryError: If a library for its format is not installed.
    """
    path = Path(path)
    if path.is_dir():
        if (path / "metadata.yaml").is_file():
            return _ros(path, drone)
        if not (path / "log.npz").is_file():
            raise RangeError(f"{path} is a folder without metadata.yaml (rosbag2) and without log.npz")
        path = path / "log.npz"
    if not path.is_file():
        raise UnknownNameError(f"no file '{path}'")
    name = path.name.lower()
    if name.endswith(csv_log.SUFFIXES):
        return csv_log.read_csv(path)
    if name.endswith(".npz"):
        from crazychoir_fw.comparison.npz_log import read_npz

        return read_npz(path, drone)
    if name.endswith(".mcap"):
        return _ros(path, drone)
    with path.open("rb") as file:
        first = file.read(1)
    if first == bytes([MAGIC]):
        from crazychoir_fw.comparison.usd_log import read_usd

        return read_usd(path)
    raise RangeError(f"{path.name}: format not known, allowed: {FORMATS}")


def _ros(path: Path, drone: str | None) -> RawLog:
    from crazychoir_fw.comparison.ros_log import read_ros

    return read_ros(path, drone)
