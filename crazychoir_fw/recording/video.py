"""Film files from pictures: H.264, GIF or WebP."""

from pathlib import Path
from types import TracebackType
from typing import Any

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray

from crazychoir_fw.common.replacing import replacing

_GIF = "split[a][b];[a]palettegen=max_colors=128[p];[b][p]paletteuse=dither=bayer:bayer_scale=4"
_ENCODERS = {
    ".mp4": ("libx264", "yuv420p", ["-preset", "veryfast", "-movflags", "+faststart"]),
    ".gif": ("gif", "pal8", ["-filter_complex", _GIF, "-loop", "0"]),
    ".webp": ("libwebp_anim", "yuv420p", ["-quality", "70", "-compression_level", "4", "-loop", "0"]),
}
"""Encoder, format of its pixels and options, by the suffix of the file."""

SUFFIXES = tuple(_ENCODERS)


class VideoWriter:
    """Writes pictures to a file that appears under its name when it is complete.

    Use it as a context manager; if the block raises, nothing is left behind.

    Args:
        path: The file: `.mp4` (H.264, yuv420p), `.gif` or `.webp`.
        fps: Pictures per second.
        crf: Quality of H.264, 0 (lossless) to 51; 20 looks good.

    Raises:
        ValueError: If it is no such file, or the rate is impossible.
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
        self._sink: Any = None

    def __enter__(self) -> "VideoWriter":
        self._replacing = replacing(self._path)
        self._temporary = self._replacing.__enter__()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._sink is not None:
            self._sink.close()
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
            codec, pixels, options = _ENCODERS[self._path.suffix.lower()]
            quality = ["-crf", str(self._crf)] if codec == "libx264" else []
            self._sink = imageio_ffmpeg.write_frames(
                str(self._temporary),
                self._size,
                fps=self._fps,
                codec=codec,
                pix_fmt_out=pixels,
                quality=None,
                macro_block_size=2,
                ffmpeg_log_level="error",
                output_params=[*quality, *options],
            )
            self._sink.send(None)
        if self._size is not None and (width, height) != self._size:
            raise ValueError(f"picture is {width} x {height} pixels, the film is {self._size[0]} x {self._size[1]}")
        self._sink.send(np.ascontiguousarray(picture[:height, :width]))
