"""Film files from pictures: H.264, GIF or WebP, by ffmpeg; without it, GIF."""

import shutil
import subprocess
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Protocol

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.common.replacing import replacing

_GIF = "split[a][b];[a]palettegen=max_colors=128[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"
_ENCODERS = {
    ".mp4": ("libx264", "yuv420p", ["-preset", "veryfast", "-movflags", "+faststart"]),
    ".gif": ("gif", "pal8", ["-filter_complex", _GIF, "-loop", "0"]),
    ".webp": ("libwebp_anim", "yuv420p", ["-quality", "70", "-compression_level", "4", "-loop", "0"]),
}
"""Encoder, format of its pixels and options, by the suffix of the file."""

SUFFIXES = tuple(_ENCODERS)


def find_ffmpeg() -> str | None:
    """Return the path of ffmpeg, that of the package `imageio-ffmpeg` or of the system; None if there is none."""
    with suppress(ImportError, RuntimeError):
        import imageio_ffmpeg

        return str(imageio_ffmpeg.get_ffmpeg_exe())
    return shutil.which("ffmpeg")


def usual_name() -> str:
    """Return the name of a flight's film: `flight.mp4`, or `flight.gif` where there is no ffmpeg."""
    return "flight.gif" if find_ffmpeg() is None else "flight.mp4"


class _Sink(Protocol):
    def write(self, picture: NDArray[np.uint8]) -> None:
        """Append a picture."""

    def close(self) -> None:
        """Complete the file."""


class _FfmpegSink:
    """Pipes raw pictures to ffmpeg."""

    def __init__(self, ffmpeg: str, path: Path, suffix: str, size: tuple[int, int], fps: float, crf: int) -> None:
        codec, pixels, options = _ENCODERS[suffix]
        quality = ["-crf", str(crf)] if codec == "libx264" else []
        pictures = ["-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{size[0]}x{size[1]}", "-r", f"{fps:g}", "-i", "-"]
        encoder = ["-an", "-vcodec", codec, "-pix_fmt", pixels, *quality, *options]
        words = [ffmpeg, "-y", "-v", "error", *pictures, *encoder, str(path)]
        self._process = subprocess.Popen(words, stdin=subprocess.PIPE, stderr=subprocess.PIPE)

    def write(self, picture: NDArray[np.uint8]) -> None:
        if self._process.stdin is not None:
            try:
                self._process.stdin.write(np.ascontiguousarray(picture).data)
            except BrokenPipeError:
                self.close()

    def close(self) -> None:
        _, complaint = self._process.communicate()
        if self._process.returncode:
            raise ValueError(f"ffmpeg failed: {complaint.decode(errors='replace').strip()[-300:]}")


class _PillowSink:
    """Keeps pictures of 128 colors, and writes a GIF at the end."""

    def __init__(self, path: Path, fps: float) -> None:
        self._path = path
        self._duration_ms = 1000.0 / fps
        self._pictures: list[Image.Image] = []

    def write(self, picture: NDArray[np.uint8]) -> None:
        self._pictures.append(Image.fromarray(picture).quantize(128, dither=Image.Dither.NONE))

    def close(self) -> None:
        first, *others = self._pictures
        first.save(
            self._path, "GIF", save_all=True, append_images=others, duration=self._duration_ms, loop=0, optimize=False
        )


class VideoWriter:
    """Writes pictures to a file that appears under its name when it is complete.

    Use it as a context manager; if the block raises, nothing is left behind.

    Args:
        path: The file: `.mp4` (H.264, yuv420p), `.gif` or `.webp`.
        fps: Pictures per second.
        crf: Quality of H.264, 0 (lossless) to 51; 20 looks good.

    Raises:
        ValueError: If it is no such file, or the rate is impossible.
        MissingLibraryError: If there is no ffmpeg and the file is no GIF.
    """

    def __init__(self, path: Path, *, fps: float = 25.0, crf: int = 20) -> None:
        if not 0.0 < fps <= 1000.0:
            raise ValueError(f"fps {fps} is outside (0, 1000]")
        self._path = Path(path)
        if self._path.suffix.lower() not in _ENCODERS:
            raise ValueError(f"{path} is no film, allowed: a name that ends with {', '.join(SUFFIXES)}")
        self._fps = fps
        self._crf = crf
        self._size: tuple[int, int] | None = None
        self._sink: _Sink | None = None
        self._ffmpeg = find_ffmpeg()
        if self._ffmpeg is None and self._path.suffix.lower() != ".gif":
            raise MissingLibraryError(
                f"{self._path.name} needs ffmpeg: run pip install 'crazychoir-fw[video]', or write a .gif"
            )

    def __enter__(self) -> "VideoWriter":
        self._replacing = replacing(self._path)
        self._temporary = self._replacing.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._sink is not None:
            self._close(self._sink, kind is None)
        elif kind is None:
            # leave through the door for failures, so that no empty file takes the place of an older film
            error = ValueError(f"no pictures were written to {self._path}")
            kind = ValueError
            self._replacing.__exit__(kind, error, None)
            raise error
        self._replacing.__exit__(kind, error, trace)

    def write(self, picture: NDArray[np.uint8]) -> None:
        """Append one picture.

        Args:
            picture: RGB, shape (height, width, 3); an odd last row or column is cut off, which the format asks for.

        Raises:
            ValueError: If the picture is not RGB of 8 bits, or its size differs from that of the first.
        """
        if picture.ndim != 3 or picture.shape[2] != 3 or picture.dtype != np.uint8:
            raise ValueError(f"picture has shape {picture.shape} and type {picture.dtype}, expected (H, W, 3) uint8")
        height, width = picture.shape[0] // 2 * 2, picture.shape[1] // 2 * 2
        if self._sink is None:
            if not height or not width:
                raise ValueError(f"picture has shape {picture.shape}, expected at least 2 x 2 pixels")
            self._size = (width, height)
            self._sink = self._open(self._size)
        if self._size is not None and (width, height) != self._size:
            raise ValueError(f"picture is {width} x {height} pixels, the film is {self._size[0]} x {self._size[1]}")
        self._sink.write(picture[:height, :width])

    def _open(self, size: tuple[int, int]) -> _Sink:
        if self._ffmpeg is None:
            return _PillowSink(self._temporary, self._fps)
        return _FfmpegSink(self._ffmpeg, self._temporary, self._path.suffix.lower(), size, self._fps, self._crf)

    def _close(self, sink: _Sink, is_wanted: bool) -> None:
        try:
            sink.close()
        except (ValueError, OSError) as error:
            if is_wanted:
                self._replacing.__exit__(type(error), error, None)
                raise
