"""The least bias that removes acne: planes against their closed forms, counts against those of other functions."""

from __future__ import annotations

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.experiments.bias_looks import BiasLooks

PARTS = ("world", "texels", "ndc", "slope")
SIZE = (320, 180)
# Rasterisers take the plane of depth through vertices rounded to 1/256 of a texel: docs/bias.md.
SNAPPED = 1.0 + 1.0 / 256.0
# Of 57,600 pixels some lie near the corner of their texel: within a twentieth of its side along both axes a hundredth.
NEAR_CORNER = 0.93
TOLERANCE = 1e-3


def plane_view(seed: int, light: object = None) -> sl.View:
    """An endless plane, as far as it is seen, whose normal is 10 to 75 degrees away from the light."""
    rng = np.random.default_rng(seed)
    to_light = rng.normal(size=3)
    to_light /= np.linalg.norm(to_light)
    across = np.cross(to_light, rng.normal(size=3))
    across /= np.linalg.norm(across)
    angle = np.radians(rng.uniform(10, 75))
    normal = np.cos(angle) * to_light + np.sin(angle) * across
    u = np.cross(normal, rng.normal(size=3))
    u /= np.linalg.norm(u)
    v = np.cross(normal, u)
    corners = [30 * (a * u + b * v) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    scene = sl.Scene.from_arrays(np.array(corners), [[0, 1, 2], [0, 2, 3]])
    # From a side that leaves the picture full of the plane.
    camera = sl.Camera.look_at(6 * normal + 2 * u, (0, 0, 0), up=tuple(u), aspect=16 / 9, near=0.5, far=60)
    return sl.View(scene, camera, sl.DirectionalLight(-to_light) if light is None else light, size=SIZE)


def found_in(view: sl.View, technique: str | sl.Parameterization = "uniform", part: str = "slope", **changes: object):
    options = {"resolution": 512, "renderer": "cpu", "progress": False, **changes}
    return sl.smallest_bias(view, technique, part, **options)


@pytest.fixture(scope="module")
def robots() -> sl.View:
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=SIZE)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("part", PARTS)
def test_a_plane_needs_its_closed_form(seed, part):
    view = plane_view(seed)
    found = found_in(view, "uniform", part, acne=0.0)
    # By hand: on the plane a step across the light moves along the ray by -(n . step) / (n . l).
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light, resolution=512)
    rows, to_light = p.matrix, -np.asarray(view.light.direction)
    normal = view.gbuffer("cpu").normal[90, 160].astype(float)
    sides = [np.asarray(rows[i, :3]) / np.dot(rows[i, :3], rows[i, :3]) * 2 / 512 for i in range(2)]
    world = 0.5 * sum(abs(np.dot(normal, side) / np.dot(normal, to_light)) for side in sides)
    by_hand = {
        "slope": 1.0,
        "world": world,
        "texels": world / max(np.linalg.norm(side) for side in sides),
        "ndc": world * abs(np.dot(rows[2, :3], to_light)),
    }[part]
    assert found.closed_form == pytest.approx(by_hand, rel=1e-5)  # normals are in single precision
    assert NEAR_CORNER * by_hand < found.value < by_hand * SNAPPED * (1 + TOLERANCE)
    assert found.acne == 0 < found.curve.acne[0]
    assert found.leaks == 0, "a plane shades nothing"


@pytest.mark.parametrize(
    ("technique", "post_warp"),
    [
        ("lispsm", "none"),
        ("tsm", "none"),
        ("log_psm", "log"),
        ("rectilinear", "rectilinear"),
        ("z_partition:count=3,inner=lispsm", "none"),
    ],
)
@pytest.mark.parametrize("part", PARTS)
def test_a_plane_needs_no_more_than_its_closed_form_in_any_map(technique, post_warp, part):
    view = plane_view(11)
    p = sl.evaluate(view, technique, 512, metrics=[], renderer="cpu").parameterization
    assert {one.post_warp for one in p.partitions} == {post_warp}
    found = found_in(view, technique, part, acne=0.0)
    # The closed form is that of the pixel that needs most; its place in its texel may be a better one.
    assert 0.5 * found.closed_form < found.value < found.closed_form * SNAPPED * (1 + TOLERANCE)
    assert found.curve.acne[0] > 1000


@pytest.mark.parametrize("kind", ["spot", "point"])
@pytest.mark.parametrize("part", PARTS)
def test_placed_lights(kind, part):
    view = plane_view(3)
    at = -9 * np.asarray(view.light.direction)
    light = sl.SpotLight(at, -at, cone_angle=1.6, range=60) if kind == "spot" else sl.PointLight(at, range=60)
    view = plane_view(3, light)
    found = found_in(view, "uniform", part, acne=0.0)
    # Depth in single precision: of this plane, which comes near to the light, up to some per cent of what it gains.
    looks = BiasLooks(
        view, sl.technique("uniform"), 512, sl.Renderer("cpu"), "ndc", sl.Bias.none(), "nearest", sl.Stored()
    )
    rounding = 2.0**-24 / looks.of_planes().min()
    assert 0 < rounding < 0.05
    assert 0.5 * found.closed_form < found.value < found.closed_form * (SNAPPED + rounding) * (1 + TOLERANCE)
    assert found.curve.acne[0] > 1000


@pytest.mark.parametrize("part", PARTS)
def test_a_wider_filter_needs_more_of_all_but_the_slope(part):
    nearest, wide = (found_in(plane_view(2), "uniform", part, filter=one) for one in ("nearest", "bilinear"))
    factor = 1.0 if part == "slope" else 2.0
    assert wide.closed_form == pytest.approx(factor * nearest.closed_form)
    # At one half the four weighted comparisons need less than all of their reach.
    assert 0 < wide.value < wide.closed_form


@pytest.mark.parametrize("part", PARTS)
def test_other_parts_lessen_what_is_needed(part):
    view = plane_view(5)
    rest = sl.Bias(world=1e-3, texels=0.05, ndc=1e-6, slope=0.25, slope_limit=float("inf"), plane=0.2, normal=0.05)
    alone, beside = (found_in(view, "uniform", part, acne=0.0, bias=bias) for bias in (None, rest))
    assert getattr(beside.bias, part) == 0
    assert NEAR_CORNER * beside.closed_form < beside.value < alone.value
    assert beside.value < beside.closed_form * SNAPPED * (1 + TOLERANCE) + 0.01 * alone.closed_form


@pytest.mark.parametrize("technique", ["uniform", "lispsm", "z_partition:count=2"])
@pytest.mark.parametrize("part", PARTS)
def test_the_counts_are_those_of_an_evaluation(robots, technique, part):
    found = found_in(robots, technique, part)
    assert found.allowed == int(0.001 * found.lit)
    assert found.acne <= found.allowed

    def again(value: float) -> sl.Run:
        parts = {"world": 0, "texels": 0, "ndc": 0, "slope": 0, "slope_limit": float("inf"), "plane": 0, part: value}
        return sl.evaluate(
            robots, technique, 512, metrics=["causes"], renderer="cpu", bias=sl.Bias(**parts)
        )  # fmt: skip

    for value in (0.0, 0.4 * found.value, found.value, 1.5 * found.value):
        run, own = again(value), found_in_curve(robots, technique, part, value)
        assert (run.causes.acne, run.errors.false_shadow, run.errors.false_light) == own
    run = again(found.value)
    assert (found.acne, found.leaks, found.wrong) == (run.causes.acne, run.errors.false_light, run.errors.count)
    assert again(found.value * (1 - 2 * TOLERANCE)).causes.acne > found.allowed, "a smaller value would do"
    best = again(found.least_wrong_value)
    assert best.errors.count == found.least_wrong


def found_in_curve(view: sl.View, technique: str, part: str, value: float) -> tuple[int, int, int]:
    looks = BiasLooks(
        view, sl.technique(technique), 512, sl.Renderer("cpu"), part, sl.Bias.none(), "nearest", sl.Stored()
    )
    return tuple(looks.counts(value))


@pytest.mark.parametrize("name", ["robots", "forest", "statues"])
@pytest.mark.parametrize("filter", ["nearest", "bilinear"])
@pytest.mark.parametrize("part", PARTS)
def test_acne_only_falls_and_false_light_only_rises(name, filter, part):
    scene = sl.library.scene(name)
    found = found_in(sl.View(scene, scene.camera, scene.light, size=SIZE), "lispsm", part, filter=filter)
    curve = found.curve
    assert curve.value.is_monotonic_increasing
    assert curve.value[0] == 0
    assert curve.value.is_unique
    assert curve.acne.is_monotonic_decreasing
    assert curve.false_shadow.is_monotonic_decreasing
    assert curve.leaks.is_monotonic_increasing
    assert (curve.wrong == curve.false_shadow + curve.leaks).all()
    assert (curve.acne <= curve.false_shadow).all()
    assert curve.acne[0] > 1000
    assert curve.wrong.min() == found.least_wrong
    at = curve[curve.value == found.value].iloc[0]
    assert (at.acne, at.leaks, at.wrong) == (found.acne, found.leaks, found.wrong)
    assert (curve.acne[curve.value < found.value] > found.allowed).all()


@pytest.mark.parametrize("part", ["slope", "world"])
def test_no_value_has_fewer_wrong_pixels(robots, part):
    found = found_in(robots, "lispsm", part)
    tried = [
        sum(found_in_curve(robots, "lispsm", part, value)[1:])
        for value in np.linspace(0, 3 * found.least_wrong_value, 60)
    ]
    assert found.least_wrong_bound <= min(tried)
    assert found.least_wrong_bound <= found.least_wrong <= min(tried) / 0.99


def test_shares(robots):
    values = [found_in(robots, "lispsm", acne=share).value for share in (0.0, 0.001, 0.01, 0.1, 1.0)]
    assert values == sorted(values, reverse=True)
    assert values[-1] == 0.0
    assert values[-2] > 0
    assert found_in(robots, "lispsm", acne=0.0).acne == 0


def test_a_part_that_cannot_do_it():
    # Straight across the light a plane has no slope; its acne here comes from a bias the wrong way.
    scene = sl.Scene.from_arrays([[-9, 0, -9], [9, 0, -9], [9, 0, 9], [-9, 0, 9]], [[0, 2, 1], [0, 3, 2]])
    camera = sl.Camera.look_at((0, 5, 6), (0, 0, 0), aspect=16 / 9, near=1, far=40)
    view = sl.View(scene, camera, sl.DirectionalLight((0, -1, 0)), size=SIZE)
    away = sl.Bias(world=-0.25, texels=0, ndc=0, slope=0, slope_limit=float("inf"))
    found = found_in(view, bias=away)
    assert found.value is None
    assert found.acne == found.lit > 0
    assert "no value" in str(found)
    assert "Add another part" in str(found)
    assert found.least_wrong == found.lit
    assert found.least_wrong_value == 0.0
    found.figure()
    # Without what moved it away there is none but by rounding; another part brings it back by as much.
    assert found_in(view, part="world", bias=away).value < 1e-9
    put_back = found_in(view, part="ndc", bias=away)
    depth = abs(sl.technique("uniform").parameterize(scene, camera, view.light, resolution=512).matrix[2, 1])
    assert put_back.value == pytest.approx(0.25 * depth, rel=2 * TOLERANCE)


def test_nothing_to_mend():
    view = plane_view(1)
    away = sl.View(view.scene, view.camera.replace(target=2 * view.camera.eye), view.light, size=SIZE)
    found = found_in(away)
    assert (found.value, found.lit, found.acne, found.leaks, found.closed_form) == (0.0, 0, 0, 0, 0.0)
    assert "none is needed" in found.verdict
    found.figure()
    behind = sl.View(view.scene, view.camera, sl.DirectionalLight(-np.asarray(view.light.direction)), size=SIZE)
    assert found_in(behind).value == 0.0


def test_several_lights_share_the_value(robots):
    lights = (robots.light, sl.DirectionalLight((-0.6, -1, 0.2)))
    both = found_in(sl.View(robots.scene, robots.camera, lights, size=SIZE), "lispsm")
    apart = [found_in_curve(sl.View(robots.scene, robots.camera, one, size=SIZE), "lispsm", "slope", both.value)
             for one in lights]  # fmt: skip
    assert both.acne == sum(one[0] for one in apart)
    assert both.leaks == sum(one[2] for one in apart)


def test_one_map_is_drawn(robots):
    class Counting:
        """A renderer that counts its maps."""

        backend, adapter = "cpu", "counting"

        def __init__(self) -> None:
            self.real, self.maps = sl.Renderer("cpu"), 0

        def gbuffer(self, *args, **keywords):
            return self.real.gbuffer(*args, **keywords)

        def shadow_mask(self, *args, **keywords):
            raise AssertionError("masks are looked up")

        def shadow_map(self, *args, **keywords):
            self.maps += 1
            return self.real.shadow_map(*args, **keywords)

    counting = Counting()
    found = found_in(robots, "uniform", renderer=counting)
    assert counting.maps == 1
    assert len(found.curve) > 20


def test_given_matrices(robots):
    p = sl.technique("lispsm").parameterize(robots.scene, robots.camera, robots.light, resolution=512,
                                            samples=robots.samples(renderer="cpu"))  # fmt: skip
    given, named = found_in(robots, p), found_in(robots, "lispsm")
    assert (given.value, given.acne, given.leaks) == (named.value, named.acne, named.leaks)


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        ({"part": "plane"}, sl.errors.UnknownNameError, "part: unknown part 'plane'"),
        ({"part": 3}, sl.errors.ArgumentError, "part: expected one of"),
        ({"acne": -0.1}, sl.errors.ArgumentError, "acne: expected a share of the lit pixels from 0 to 1, got -0.1"),
        ({"acne": 1.5}, sl.errors.ArgumentError, "acne: expected a share"),
        ({"acne": float("nan")}, sl.errors.ArgumentError, "acne: expected a finite number"),
        ({"acne": "few"}, sl.errors.ArgumentError, "acne"),
        ({"bias": 0.1}, sl.errors.ArgumentError, "bias: expected a Bias"),
        ({"filter": "soft"}, sl.errors.UnknownNameError, "filter: unknown filter"),
        ({"resolution": 0}, sl.errors.ArgumentError, "resolution"),
        ({"technique": "nothing"}, sl.errors.UnknownNameError, "nothing"),
        ({"renderer": "fast"}, sl.errors.UnknownNameError, "renderer"),
        ({"progress": 1}, sl.errors.ArgumentError, "progress"),
        ({"view": 1}, sl.errors.ArgumentError, "view: expected a View"),
    ],
)
def test_bad_input(robots, change, error, said):
    arguments = {"view": robots, "technique": "uniform", "resolution": 64, "renderer": "cpu", "progress": False}
    with pytest.raises(error, match=said):
        sl.smallest_bias(**{**arguments, **change})


def test_the_figure_shows_the_curve(robots):
    from plot_support import lone_axes

    found = found_in(robots, "lispsm")
    ax = sl.plot.bias_curve(found, lone_axes())
    drawn = {line.get_label(): np.asarray(line.get_ydata()) for line in ax.lines}
    for words, name in (("acne", "acne"), ("false light", "leaks"), ("all wrong pixels", "wrong")):
        assert np.array_equal(drawn[words], found.curve[name])
    assert drawn[f"least value, {found.value:.4g}"][0] == found.acne
    assert drawn[f"fewest wrong, {found.least_wrong_value:.4g}"][0] == found.least_wrong
    assert "endless planes, 1" in drawn
    with pytest.raises(sl.errors.ArgumentError, match="found: expected a SmallestBias"):
        sl.plot.bias_curve(3)
