"""Pictures as PNG files: another program reads the pixels that went in."""

from __future__ import annotations

import io

import numpy as np
import pytest
from PIL import Image

import shadowlab as sl
from shadowlab import pictures
from shadowlab.pictures import png
from shadowlab.reports.html.album import Album

RANDOM = np.random.default_rng(3)


def read(data: bytes) -> np.ndarray:
    """The pixels of a PNG file, as Pillow reads them."""
    with Image.open(io.BytesIO(data)) as image:
        assert (image.format, image.mode) == ("PNG", "RGB")
        image.load()
        return np.asarray(image)


@pytest.mark.parametrize("shape", [(1, 1), (1, 7), (9, 1), (64, 33), (300, 500)])
def test_another_program_reads_the_pixels(shape):
    picture = RANDOM.integers(0, 256, (*shape, 3)).astype(np.uint8)
    np.testing.assert_array_equal(read(png(picture)), picture)
    np.testing.assert_array_equal(read(png(picture[::-1, ::-1])), picture[::-1, ::-1])


def test_one_changed_byte_is_another_file():
    picture = np.full((20, 30, 3), 90, np.uint8)
    before = png(picture)
    picture[7, 11, 2] += 1
    after = png(picture)
    assert before != after
    assert (read(before) != read(after)).sum() == 1


def test_pictures_of_surfaces_are_packed():
    scene = sl.library.scene("robots")
    g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(320, 180))
    picture = pictures.shade(g, scene.light, np.ones((180, 320), np.float32))
    with io.BytesIO() as stream:
        Image.fromarray(picture).save(stream, format="PNG", compress_level=6)
        # The filter chosen for each row, and a level that takes three times as long.
        least = len(stream.getvalue())
    assert len(png(picture)) < 1.3 * least < 0.2 * picture.nbytes


def test_an_album_draws_each_picture_once_and_puts_it_where_its_marks_are():
    drawn = []

    def draw(value):
        drawn.append(value)
        return np.full((4, 5, 3), value, np.uint8)

    album = Album()
    first, second = album.add(lambda: draw(10), "a.png"), album.add(lambda: draw(20))
    assert "a.png" in album
    assert "b.png" not in album
    page, files = album.finished(f"<{first}><{second}><{first}>")
    assert sorted(drawn) == [10, 20]
    assert list(files) == ["a.png"]
    np.testing.assert_array_equal(read(files["a.png"]), np.full((4, 5, 3), 10, np.uint8))
    one, two, again = page.strip("<>").split("><")
    assert one == again != two
    assert one.startswith("data:image/png;base64,")


def test_an_error_of_a_picture_comes_out():
    album = Album()

    def fail():
        raise RuntimeError("no picture")

    album.add(fail)
    with pytest.raises(RuntimeError, match="no picture"):
        album.finished("")
