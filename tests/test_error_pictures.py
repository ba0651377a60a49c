"""Pictures of errors and causes: colours at known errors, for all kinds of colour vision and in grey."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from plot_support import SUN, footprint, view

from shadowlab import pictures
from shadowlab.aliasing.causes import CAUSES
from shadowlab.errors import ArgumentError
from shadowlab.pictures import bands
from shadowlab.pictures import causes as cause_pictures
from shadowlab.pictures import errors as error_pictures

# A warning of numpy is a failure.
pytestmark = pytest.mark.filterwarnings("error")

# Machado, Oliveira, Fernandes 2009 [machado2009], a model for simulation of color vision deficiency, severity
# 1.0, on linear RGB.
VISIONS = {
    "common": np.eye(3),
    "protanopia": np.array(
        [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]
    ),
    "deuteranopia": np.array(
        [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]
    ),
    "tritanopia": np.array(
        [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]
    ),
}
XYZ = np.array(
    [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
)
# In CIELAB about 2 is the least that is seen side by side, 10 is seen at a glance.
AT_A_GLANCE = 10.0


def lab(colours, vision="common"):
    """CIELAB of sRGB bytes as an eye of this vision sees them."""
    c = np.asarray(colours, np.float64) / 255
    linear = np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)
    t = np.clip(linear @ VISIONS[vision].T, 0, 1) @ XYZ.T / XYZ.sum(axis=1)
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=-1)


@pytest.mark.parametrize("vision", VISIONS)
def test_lightness_falls_all_along_the_scale(vision):
    lightness = lab(error_pictures.SCALE, vision)[:, 0]
    # Bytes round: neighbours may be equal, an eighth of the scale may not.
    assert np.diff(lightness).max() < 0.3
    assert np.diff(lightness[::16]).max() < -0.3
    assert lightness[0] - lightness[-1] > 70


@pytest.mark.parametrize("vision", VISIONS)
def test_below_one_is_apart_from_above(vision):
    half = error_pictures.STEPS
    below, above = lab(error_pictures.SCALE[:half], vision), lab(error_pictures.SCALE[half:], vision)
    distances = np.linalg.norm(below[:, None] - above[None], axis=-1)
    assert distances.min() > AT_A_GLANCE
    assert below[:, 0].min() - above[:, 0].max() > 7  # a grey print keeps it


@pytest.mark.parametrize("vision", ["common", "protanopia", "deuteranopia"])
def test_octaves_are_apart(vision):
    colours = lab(error_pictures.error_colours([0.5, 1, 2, 4, 8]), vision)
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(colours, 2)) > AT_A_GLANCE


def test_known_errors_have_the_published_colours():
    picture = error_pictures.error_picture(footprint([[0.5, 1.0, 3.0, 10.0, 100.0, np.inf]]))
    half, green, middle, dark, beyond, worst = picture[0].astype(int)
    assert half[2] > half[1] > half[0]  # blue
    assert tuple(green) == error_pictures.UNDERSAMPLED_RGB[0]
    assert green[1] > max(green[0], green[2]) + 50
    assert middle[0] > middle[1] > middle[2]  # orange
    assert tuple(dark) == tuple(beyond) == tuple(worst) == error_pictures.UNDERSAMPLED_RGB[-1]
    assert dark[0] > 90 > 30 > max(dark[1:])


def test_the_ends_of_the_halves_are_exact():
    below, one, above = np.nextafter(np.float32(1), 0), np.float32(1), np.nextafter(np.float32(1), 2)
    colours = error_pictures.error_colours(np.array([below, one, above], np.float32))
    assert tuple(colours[0]) == error_pictures.OVERSAMPLED_RGB[-1]
    assert tuple(colours[1]) == tuple(colours[2]) == error_pictures.UNDERSAMPLED_RGB[0]
    assert (error_pictures.error_colours([0.0, 1e-30, 0.1]) == error_pictures.OVERSAMPLED_RGB[0]).all()


def test_a_change_of_one_pixel_changes_that_pixel():
    major = np.full((7, 9), 2.0)
    before = error_pictures.error_picture(footprint(major))
    major[3, 4] = 3.0
    after = error_pictures.error_picture(footprint(major))
    assert np.argwhere((before != after).any(axis=-1)).tolist() == [[3, 4]]


@pytest.mark.parametrize("shaded", [False, True])
def test_pixels_without_a_texel_are_grey_and_say_why(shaded):
    codes = np.repeat(np.array([[0, -1, -2, -3]]), 16, axis=0).repeat(8, axis=1)
    g = view(*codes.shape)
    g.normal[:8, :, 1] = -1.0  # half of them averted, and darker
    given = {"gbuffer": g, "light": SUN} if shaded else {}
    picture = error_pictures.error_picture(footprint(np.ones(codes.shape), codes), **given).astype(int)
    kinds = [picture[codes == code] for code in (-1, -2, -3)]
    assert all((np.ptp(kind, axis=-1) == 0).all() for kind in kinds)
    no_map, averted, nothing = kinds
    assert averted.max() < no_map.min() < no_map.max() < nothing.min() == 255
    assert len(np.unique(averted)) > 1  # hatched
    # No grey is a colour of the scale, to any eye.
    for vision in VISIONS:
        greys = lab(np.unique(np.concatenate(kinds), axis=0), vision)
        scale = lab(error_pictures.SCALE, vision)
        assert np.linalg.norm(greys[:, None] - scale[None], axis=-1).min() > 4


@pytest.mark.parametrize("code", [0, -1, -2, -3])
def test_one_pixel_has_a_picture(code):
    picture = error_pictures.error_picture(footprint([[2.0]], [[code]]))
    assert picture.shape == (1, 1, 3)
    assert picture.dtype == np.uint8


def test_other_values_take_the_place_of_the_major_extent():
    e = footprint(np.full((2, 3), 20.0), [[0, 0, 0], [-1, -2, -3]])
    values = np.array([[0.5, 1, 3], [np.nan, np.nan, -7]])
    other = error_pictures.error_picture(e, values=values)
    np.testing.assert_array_equal(other[0], error_pictures.error_colours([0.5, 1, 3]))
    np.testing.assert_array_equal(other[1], error_pictures.error_picture(e)[1])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"values": np.ones((3, 2))}, r"values: expected numbers of shape \(2, 3\)"),
        ({"values": "abc"}, "values: expected an array of float64"),
        ({"values": np.full((2, 3), np.nan)}, "got NaN"),
        ({"values": np.full((2, 3), -1.0)}, "negative"),
        ({"gbuffer": view(2, 3)}, "expected both or neither"),
        ({"gbuffer": view(3, 3), "light": SUN}, r"gbuffer: expected shape \(2, 3\)"),
    ],
)
def test_wrong_arguments_say_what_was_expected(given, says):
    with pytest.raises(ArgumentError, match=says):
        error_pictures.error_picture(footprint(np.ones((2, 3))), **given)


def test_a_footprint_of_points_is_no_image():
    with pytest.raises(ArgumentError, match="of an image"):
        error_pictures.error_picture(footprint(np.ones(4)))
    with pytest.raises(ArgumentError, match="expected a Footprint, got 3"):
        error_pictures.error_picture(3)


def test_the_scale_of_a_page_explains_what_it_is_asked():
    svg = error_pictures.error_scale_svg()
    assert svg.startswith("<svg")
    assert svg.count("<text") == svg.count("</text>") == 7 + 3 + 3
    assert all(words in svg for words in error_pictures.WORDS.values())
    for colour in (error_pictures.UNDERSAMPLED_RGB[-1], error_pictures.OVERSAMPLED_RGB[0]):
        assert error_pictures.rgb(colour) in svg
    bare = error_pictures.error_scale_svg((0, 3), label="a < b, pixels")
    assert "a &lt; b" in bare
    assert not any(words in bare for words in error_pictures.WORDS.values())


@pytest.mark.parametrize("vision", VISIONS)
def test_causes_are_apart_and_from_the_view_beneath(vision):
    colours = lab(list(cause_pictures.CAUSE_RGB.values()), vision)
    assert min(np.linalg.norm(a - b) for a, b in itertools.combinations(colours, 2)) > 2 * AT_A_GLANCE
    beneath = lab([(cause_pictures.DARKEST,) * 3], vision)
    assert colours[:, 0].max() < beneath[0, 0] - AT_A_GLANCE


def test_causes_are_those_of_the_analysis():
    assert list(cause_pictures.CAUSE_RGB) == list(CAUSES)
    assert cause_pictures.CAUSE_RGB[1] == pictures.FALSE_SHADOW_RGB
    assert cause_pictures.CAUSE_RGB[3] == pictures.FALSE_LIGHT_RGB


def test_each_cause_has_its_colour_and_grows_without_hiding_another():
    codes = np.zeros((6, 8), np.int8)
    codes[2, 1:6] = 1, 2, 3, 4, 5
    codes[5] = -1
    for width in (1, 3):
        picture = cause_pictures.cause_picture(view(), SUN, np.ones((6, 8), np.int8), codes, width=width)
        assert [tuple(p) for p in picture[2, 1:6]] == list(cause_pictures.CAUSE_RGB.values())
    right = cause_pictures.cause_picture(view(), SUN, np.ones((6, 8), np.int8), codes)[codes <= 0].astype(int)
    assert (np.ptp(right, axis=-1) == 0).all()
    assert right[-8:].max() == 255  # not compared


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"truth": np.ones((2, 2), np.int8)}, "truth: expected shape"),
        ({"cause_image": np.zeros((6, 7), np.int8)}, "cause_image: expected shape"),
        ({"cause_image": np.full((6, 8), 6)}, r"cause_image: expected codes .* got \[6\]"),
        ({"width": 0}, "width: expected a whole number"),
    ],
)
def test_wrong_causes_say_what_was_expected(given, says):
    usual = {"truth": np.ones((6, 8), np.int8), "cause_image": np.zeros((6, 8), np.int8)}
    with pytest.raises(ArgumentError, match=says):
        cause_pictures.cause_picture(view(), SUN, **{**usual, **given})


def test_bands_leave_no_seam(monkeypatch):
    rng = np.random.default_rng(3)
    shape = (37, 23)
    g = view(*shape)
    g.normal[...] = rng.normal(size=(*shape, 3))
    g.normal /= np.linalg.norm(g.normal, axis=-1, keepdims=True)
    codes, truth = rng.integers(-3, 2, shape), rng.integers(-2, 2, shape).astype(np.int8)
    shown = footprint(rng.uniform(0.05, 20.0, shape), codes)
    wrong, causes = rng.integers(-1, 3, shape).astype(np.int8), rng.integers(-1, 6, shape)
    depth = np.where(rng.uniform(size=shape) < 0.3, 1.0, rng.uniform(size=shape)).astype(np.float32)

    def drawn():
        yield pictures.shade(g, SUN, rng_mask)
        yield error_pictures.error_picture(shown, gbuffer=g, light=SUN)
        yield pictures.difference(g, SUN, truth, wrong, width=3)
        yield cause_pictures.cause_picture(g, SUN, truth, causes, width=2)
        yield pictures.relief(depth)

    rng_mask = rng.uniform(size=shape).astype(np.float32)
    whole = list(drawn())
    for pixels in (1, 5 * shape[1]):
        monkeypatch.setattr(bands, "BAND_PIXELS", pixels)
        for one, other in zip(whole, drawn(), strict=True):
            np.testing.assert_array_equal(one, other)
    # A band that were drawn with the rows of another would be seen.
    assert not np.array_equal(whole[1], np.roll(whole[1], 5, axis=0))


def test_a_wide_mark_leaves_the_pixels_beside_it_their_own_colours():
    codes = np.zeros((9, 9), np.int64)
    codes[3, 3], codes[4, 4], codes[4, 3] = 5, 1, 2
    g = view(9, 9)
    picture = cause_pictures.cause_picture(g, SUN, np.ones((9, 9), np.int8), codes, width=3)
    for place in ((3, 3), (4, 4), (4, 3)):
        assert tuple(picture[place]) == cause_pictures.CAUSE_RGB[codes[place]]
    # To the right and down, the later cause over the earlier one.
    assert tuple(picture[5, 5]) == cause_pictures.CAUSE_RGB[5]
    assert tuple(picture[6, 6]) == cause_pictures.CAUSE_RGB[1]
    assert tuple(picture[2, 2]) != cause_pictures.CAUSE_RGB[5]
    assert np.ptp(picture[7, 7].astype(int)) == 0
