"""Reads NPZ files: flight logs of crazychoir (`log.npz`), and any archive with named arrays of one length."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np

from crazychoir_fw.common.errors import RangeError
from crazychoir_fw.comparison.raw_log import MAX_BYTES, RawLog, table_of
from crazychoir_fw.recording.flight_log import FlightLog

TIME = "time"


def read_npz(path: Path, drone: str | None) -> RawLog:
    """Return the columns of an archive; of a flight log those of one drone.

    Args:
        path: The file.
        drone: Its name in a flight log; None takes the first.

    Raises:
        RangeError: If it is no such file, or has no such drone.
    """
    try:
        if not zipfile.is_zipfile(path):
            raise RangeError(f"{path.name}: is no NumPy archive (.npz)")
        with zipfile.ZipFile(path) as archive:
            if sum(member.file_size for member in archive.infolist()) > 10 * MAX_BYTES:
                raise RangeError(f"{path.name}: takes more than {10 * MAX_BYTES} bytes of memory")
        with np.load(path, allow_pickle=False) as file:
            if "drone_ids" in file.files:
                return _flight(path, drone)
            arrays = {name: file[name] for name in file.files}
    except RangeError:
        raise
    except Exception as error:  # a damaged archive makes its readers raise whatever they can
        raise RangeError(f"{path.name}: cannot be read: {error or type(error).__name__}") from error
    columns = {name: values for name, values in arrays.items() if values.ndim == 1 and values.dtype.kind in "biuf"}
    for name, values in arrays.items():
        if values.ndim == 2 and values.dtype.kind in "biuf" and values.shape[1] <= 16:
            columns |= {f"{name}.{k}": values[:, k] for k in range(values.shape[1])}
    if not columns:
        raise RangeError(f"{path.name}: no arrays of numbers, (T,) or (T, n)")
    return RawLog(path.stem, "NPZ", (table_of(path.name, columns),))


def _flight(path: Path, drone: str | None) -> RawLog:
    log = FlightLog.load(path)
    if drone is not None and drone not in log.drone_ids:
        raise RangeError(f"{path.name}: has no drone '{drone}', but {', '.join(log.drone_ids)}")
    column = 0 if drone is None else log.drone_ids.index(drone)
    signals = {name: values[:, column].astype(float) for name, values in log.signals.items()}
    known = {name: values for name, values in signals.items() if not np.isnan(values).all()}
    return RawLog(path.stem, "flight log", ({TIME: log.time, **known},))
