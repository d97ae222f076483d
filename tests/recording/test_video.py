import imageio.v3 as iio
import numpy as np
import pytest
from PIL import Image, ImageSequence

from crazychoir_fw.common.errors import MissingLibraryError
from crazychoir_fw.recording import video
from crazychoir_fw.recording.video import VideoWriter


def plain(value: int, height: int = 48, width: int = 64) -> np.ndarray:
    return np.full((height, width, 3), value, dtype=np.uint8)


def test_a_film_has_the_pictures_that_were_written(tmp_path):
    path = tmp_path / "film.mp4"
    with VideoWriter(path, fps=20.0) as film:
        for value in range(0, 250, 25):
            film.write(plain(value))
        assert not path.exists()
    pictures = iio.imread(path)
    assert pictures.shape == (10, 48, 64, 3)
    np.testing.assert_allclose(pictures.mean(axis=(1, 2, 3)), np.arange(0, 250, 25), atol=4.0)
    about = iio.immeta(path)
    assert about["codec"] == "h264"
    assert about["pix_fmt"].startswith("yuv420p")
    assert about["fps"] == 20.0
    assert list(tmp_path.iterdir()) == [path]


def test_odd_sizes_become_even(tmp_path):
    with VideoWriter(tmp_path / "film.mp4") as film:
        film.write(plain(100, 49, 65))
    assert iio.imread(tmp_path / "film.mp4").shape[1:] == (48, 64, 3)


def test_a_failure_leaves_nothing_behind(tmp_path):
    with pytest.raises(KeyError), VideoWriter(tmp_path / "film.mp4") as film:
        film.write(plain(1))
        raise KeyError
    assert list(tmp_path.iterdir()) == []


def test_a_film_without_pictures_does_not_replace_an_older_one(tmp_path):
    path = tmp_path / "film.mp4"
    path.write_bytes(b"older")
    with pytest.raises(ValueError, match="no pictures"), VideoWriter(path):
        pass
    assert path.read_bytes() == b"older"
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize(
    "picture",
    [plain(1)[..., :2], plain(1)[..., 0], plain(1).astype(float), plain(1, 1, 64), plain(1, 50, 64)],
)
def test_a_picture_that_does_not_fit_is_refused(tmp_path, picture):
    with pytest.raises(ValueError, match="picture"), VideoWriter(tmp_path / "film.mp4") as film:
        if picture.shape == (50, 64, 3):
            film.write(plain(1))
        film.write(picture)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("fps", [0.0, -1.0, float("nan"), float("inf")])
def test_an_impossible_frame_rate_is_refused(tmp_path, fps):
    with pytest.raises(ValueError, match="fps"):
        VideoWriter(tmp_path / "film.mp4", fps=fps)


@pytest.mark.parametrize("suffix", [".gif", ".webp"])
def test_moving_pictures_for_a_readme(tmp_path, suffix):
    path = tmp_path / f"film{suffix}"
    with VideoWriter(path, fps=10.0) as film:
        for value in (20, 120, 220):
            film.write(plain(value))
    with Image.open(path) as image:
        pictures = np.array([np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)])
    assert pictures.shape == (3, 48, 64, 3)
    np.testing.assert_allclose(pictures.mean(axis=(1, 2, 3)), [20.0, 120.0, 220.0], atol=8.0)


def test_another_kind_of_file_is_refused(tmp_path):
    with pytest.raises(ValueError, match=r"film.avi is no film, allowed: a name that ends with .mp4, .gif, .webp"):
        VideoWriter(tmp_path / "film.avi")


def test_without_ffmpeg_there_is_a_gif(tmp_path, monkeypatch):
    monkeypatch.setattr(video, "find_ffmpeg", lambda: None)
    assert video.usual_name() == "flight.gif"
    with VideoWriter(tmp_path / "film.gif", fps=10.0) as film:
        for value in (20, 120, 220):
            film.write(plain(value))
    with Image.open(tmp_path / "film.gif") as image:
        pictures = np.array([np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)])
        assert image.info["duration"] == 100
    np.testing.assert_allclose(pictures.mean(axis=(1, 2, 3)), [20.0, 120.0, 220.0], atol=1.0)
    with pytest.raises(MissingLibraryError, match=r"film.mp4 needs ffmpeg: run pip install 'crazychoir-fw\[video\]'"):
        VideoWriter(tmp_path / "film.mp4")


def test_what_ffmpeg_complains_of_is_said(tmp_path, monkeypatch):
    monkeypatch.setitem(video._ENCODERS, ".mp4", ("no_such_encoder", "yuv420p", []))
    with (
        pytest.raises(ValueError, match=r"ffmpeg failed: .*no_such_encoder"),
        VideoWriter(tmp_path / "film.mp4") as film,
    ):
        film.write(plain(1))
    assert list(tmp_path.iterdir()) == []
