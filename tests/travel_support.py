"""Examples of every public type, which of them stay in their process, and what "bit for bit" means of an object.

Processes started by the tests import this module, so it needs nothing of pytest.
"""

from __future__ import annotations

import dataclasses
import enum
import functools
import importlib
import pkgutil
import struct
import types
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

import shadowlab as sl
from shadowlab import _core
from shadowlab.aliasing import closed_form

# A quiet NaN that is not numpy's own.
PAYLOAD = struct.unpack("<d", struct.pack("<Q", 0x7FF8_0000_0000_BEEF))[0]
PAYLOAD_32 = np.array([0x7FC0_BEEF], np.uint32).view(np.float32)[0]

# Pixels of pictures, square for the view's camera.
SIZE = (32, 18)

# Public classes that do not travel, and why.
STAYS = {
    "Store": "an open file; its path travels",
    "Renderer": "it holds a device; refusing to be pickled is tested by itself",
}
# Classes without a public name that public functions return.
UNNAMED = {
    "shadowlab.conventions.convention": ("Convention",),
    "shadowlab.doctor": ("Finding", "Report"),
    "shadowlab.pictures.light_plane": ("LightPlane",),
    "shadowlab.scene.source": ("Source",),
    "shadowlab.techniques.presets": ("ReceiversBody",),
}


def name_of(cls: type) -> str:
    """The key of `EXAMPLES`: the name of the class, told apart from the one of the package that extends it."""
    return f"_core.{cls.__name__}" if cls.__module__ == "shadowlab._core" else cls.__name__


def public_classes() -> list[type]:
    """Every class that `__all__` of the package or of a module in it names, those of the extension, and `UNNAMED`."""
    modules = [sl, _core]
    for info in pkgutil.walk_packages(sl.__path__, "shadowlab."):
        if "__main__" not in info.name:
            modules.append(importlib.import_module(info.name))
    found = {getattr(importlib.import_module(module), name) for module, names in UNNAMED.items() for name in names}
    for module in modules:
        names = getattr(module, "__all__", ()) if module is not _core else vars(_core)
        found.update(thing for name in names if isinstance(thing := getattr(module, name), type))
    found.update(thing for thing in vars(sl.errors).values() if isinstance(thing, type))
    protocols = {cls for cls in found if getattr(cls, "_is_protocol", False)}
    ours = [cls for cls in found - protocols if cls.__module__.split(".")[0] == "shadowlab"]
    return sorted(ours, key=lambda cls: (name_of(cls), cls.__module__))


@functools.cache
def view() -> tuple[Any, Any, Any]:
    """A scene, a camera and a light."""
    scene = sl.library.scene("robots")
    return scene, scene.camera, scene.light


@functools.cache
def parameterization(text: str) -> Any:
    """Maps of a technique in the view."""
    scene, camera, light = view()
    return sl.technique(text).parameterize(scene, camera, light, resolution=64)


def samples() -> list[Any]:
    """Samples of a picture with shadows, of points without, and of another light's kind."""
    scene, camera, light = view()
    seen = sl.View(scene, camera, light, size=SIZE)
    spot = sl.SpotLight((0, 30, 0), (0, -1, 0.1), cone_angle=1.2, range=100.0)
    return [
        sl.Samples.from_arrays([[0, 0, 0], [1, 0, 0]], [[0, 1, 0], [0, 1, 0]], camera),
        sl.View(scene, camera, spot, size=SIZE).samples(renderer="cpu"),
        sl.Samples.from_gbuffer(gbuffer(), camera, light, shadows=seen.truth()),
    ]


def gbuffer() -> Any:
    """A G-buffer of its own, with numbers that are easily lost: a NaN with a payload, and -0."""
    scene, camera, _ = view()
    made = sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE)
    made.normal[0, 0] = PAYLOAD_32, -0.0, 0.0
    return made


def small_scene() -> sl.Scene:
    """A scene of two meshes in three instances, one with a face that was dropped; -0 in vertices and transforms."""
    vertices = np.array([[-0.0, 0, 0], [1, 0.1, 0], [0, 2, 1 / 3], [np.nan, 0, 0]])
    meshes = [_core.Mesh(vertices[:3], [[0, 1, 2]]), _core.Mesh(vertices, [[0, 1, 3], [2, 1, 0]])]
    placed = np.array([np.eye(4)] * 3)
    placed[1, :3, 3] = -0.0, 1e-3, 7.0
    placed[2, 0, 0] = -1.0
    scene = sl.Scene(meshes, [0, 1, 0], placed)
    scene.source, scene.recipe = "somewhere.glb", "sl.load_scene('somewhere.glb')"
    scene.world_from_source = np.diag([1.0, 1, 1, 1]) + np.eye(4, k=1) * -0.0
    scene.cameras = {"eye": view()[1]}
    scene.lights = {"sun": sl.DirectionalLight((0, -1, 0)), "lamp": sl.PointLight((0, 1, 0), range=9)}
    return scene


def alpha_tests() -> list[Any]:
    """Alpha tests of four vertices, with -0 among the coordinates; the last two share a texture."""
    uv = np.array([[-0.0, 0], [1, 0.1], [1 / 3, 2], [0, 1]], np.float32)
    texture = np.arange(6, dtype=np.uint8).reshape(2, 3) * 50
    return [
        sl.AlphaTest(None, uv, 0.25, factor=0.5),
        sl.AlphaTest(texture, uv, wrap=("mirror", "clamp")),
        sl.AlphaTest(texture, uv[::-1], 1 / 3),
    ]


def leafy_scene() -> sl.Scene:
    """A scene of four meshes, of which three have alpha tests, one with a face that was dropped."""
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [0, 2, 0], [np.nan, 0, 0]])
    meshes = [_core.Mesh(vertices, [[0, 1, 3], [2, 1, 0]], alpha=alpha) for alpha in alpha_tests()]
    meshes.insert(1, _core.Mesh(vertices, [[0, 1, 2]]))
    return sl.Scene(meshes, [3, 0, 1, 2, 3], np.array([np.eye(4)] * 5))


def recorded_scenes() -> dict[str, sl.Scene]:
    """Scenes of which the hashes are on record: of numbers alone that no machine rounds otherwise."""
    return {
        "triangle": sl.Scene.from_arrays([[0, 0, 0], [1, 0, 0], [0, 2, 0]], [[0, 1, 2]]),
        "small_scene": small_scene(),
    }


def footprints() -> list[Any]:
    scene, camera, light = view()
    g = sl.Renderer("cpu").gbuffer(scene, camera, size=SIZE)
    image = sl.aliasing.footprint(g, camera, light, parameterization("lispsm"))
    points = np.asarray(g.position)[np.asarray(g.triangle) >= 0][:5]
    normals = sl.aliasing.halfway_normals(points, camera, light)
    at = sl.aliasing.footprint_at(points, normals, camera, light, parameterization("uniform"), size=64)
    depth = np.array(at.depth)
    depth[0] = PAYLOAD
    return [image, at, dataclasses.replace(at, depth=depth)]


@functools.cache
def judged() -> tuple[Any, Any, Any, Any]:
    """Mask, truth, maps and G-buffer of the view."""
    scene, camera, light = view()
    r, p, size = sl.Renderer("cpu"), parameterization("uniform"), SIZE
    mask = r.shadow_mask(scene, camera, light, p, size=size)
    truth = sl.trace.shadow_mask(scene, camera, light, size=size)
    return mask, truth, r.shadow_map(scene, p), r.gbuffer(scene, camera, size=size)


def causes() -> list[Any]:
    scene, camera, light = view()
    mask, truth, maps, g = judged()
    found = sl.aliasing.causes(scene, camera, light, parameterization("uniform"), mask, truth, gbuffer=g, maps=maps)
    distance = np.array(found.distance)
    distance[0, 0] = PAYLOAD_32
    return [found, dataclasses.replace(found, distance=distance, undecided=found.undecided + 1)]


def studies() -> Any:
    return sl.compare(*view(), ["uniform", "lispsm"], resolution=64, size=SIZE, renderer="cpu", progress=False)


def plan() -> Any:
    """A camera of parallel rays."""
    return sl.Camera.orthographic((0, 9, 0), (0, 0, 0), (0, 0, -1), height=4, near=-1, far=20)


def lens(**changes: Any) -> Any:
    return sl.Camera.look_at((0.0, -0.0, 5.0), (0.1, -0.0, 0.0), near=0.5, far=50.0).replace(**changes)


# Of each class some objects that are not equal to each other.
EXAMPLES: dict[str, Callable[[], list[Any]]] = {
    "_core.Mesh": lambda: small_scene().meshes + leafy_scene().meshes,
    "_core.Scene": lambda: [_core.Scene(small_scene()), _core.Scene(view()[0]), _core.Scene(leafy_scene())],
    "Advice": lambda: [
        sl.advise(*view(), techniques=["uniform", "lispsm"], memory=1 << 16, size=SIZE, renderer="cpu", progress=False)
    ],
    "AlphaTest": alpha_tests,
    "BeamTexels": lambda: [
        sl.aliasing.beam_texels(
            sl.aliasing.outline(view()[1], steps=n), *view()[1:], parameterization("lispsm"), size=64
        )
        for n in (1, 2)
    ],
    "Bias": lambda: [
        sl.Bias(),
        sl.Bias.none(),
        sl.Bias(world=0.01),
        sl.Bias(world=-0.01, slope_limit=np.inf),
        sl.Bias(plane=1),
        sl.Bias(normal=1),
    ],
    "Camera": lambda: [lens(), lens(near=0.25), lens(eye=(1, 2, 3)), lens(up=(1, 1, 0)), plan(), view()[1]],
    "Casters": lambda: [sl.Renderer("cpu").casters(view()[0], p) for p in (parameterization("uniform"), np.eye(4))],
    "Causes": causes,
    "Convention": lambda: [
        sl.Convention(),
        sl.Convention.of("opengl"),
        sl.Convention.of("unity:tile=(0,0.5,0.5,0.5)"),
        sl.Convention().in_atlas(2, 2),
    ],
    "Diagnosis": lambda: [
        sl.diagnose(np.eye(4), np.eye(4)),
        sl.diagnose(np.eye(4), sl.Convention.vulkan().from_ours(np.eye(4))),
    ],
    "CullRule": lambda: list(sl.aliasing.CullRule),
    "DirectionalLight": lambda: [sl.DirectionalLight((0.3, -1, -0.0)), sl.DirectionalLight((0.1, 0.7, 0.2))],
    "Ends": lambda: [closed_form.Ends(1.0, 2.0), closed_form.Ends(1.0, 3.0)],
    "Finding": lambda: list(sl.report().findings[:2]),
    "Footprint": footprints,
    "GBuffer": lambda: [gbuffer(), judged()[3], judged()[3].crop(1, 2, 3, 4)],
    "Least": lambda: [closed_form.Least(1.0, 2.0), closed_form.Least(1.0, 3.0)],
    "LibraryScene": lambda: [sl.library.scene("robots"), sl.library.scene("robots", seed=2)],
    "LightAngles": lambda: [
        sl.aliasing.over_light_angle(*view()[:2], [30, 60], ["uniform"], resolution=64, size=SIZE, progress=False)
    ],
    "LightPlane": lambda: [
        importlib.import_module("shadowlab.pictures.light_plane").LightPlane.of(light, view()[1])
        for light in (view()[2], sl.DirectionalLight((1, -1, 0)))
    ],
    "Misclassified": lambda: [
        sl.aliasing.misclassified(*judged()[:2]),
        sl.aliasing.misclassified(np.ones((2, 3)), np.zeros((2, 3), np.int8)),
    ],
    "NoTexel": lambda: list(sl.aliasing.NoTexel),
    "Difference": lambda: list(sl.aliasing.Difference),
    "Cause": lambda: list(sl.aliasing.Cause),
    "Truth": lambda: list(sl.trace.Truth),
    "_core.Note": lambda: [
        _core.Note("nothing_seen"),
        _core.Note("no_warp", ["light_along_axis"]),
        _core.Note("warp_distance_raised", values={"given": (-0.0, 1 / 3), "least": 2.0}, maps=[0, 2]),
        _core.Note("warp_distance_raised", values={"given": (-0.0, 1 / 3), "least": 2.0}),
    ],
    "Parameterization": lambda: [
        *map(
            parameterization,
            ("uniform", "lispsm:near=optimal", "z_partition:count=3,inner=lispsm", "log", "face_partition"),
        ),
        sl.Parameterization.from_matrix(np.diag([1.0, 1, -0.5, 1]) + np.eye(4, k=1) * -0.0, eye_depth=[(0, np.inf)]),
    ],
    "Partition": lambda: [
        *parameterization("z_partition:count=2").partitions,
        *parameterization("log").partitions,
        *parameterization("face_partition").partitions,
    ],
    "PixelExplanation": lambda: [
        sl.explain_pixel(sl.View(*view(), SIZE), "uniform", x, 12, resolution=64, renderer="cpu", trials=False)
        for x in (3, 20)
    ],
    "PointLight": lambda: [sl.PointLight((0, -0.0, 1), range=3), sl.PointLight((0, 0, 1), range=4)],
    "Prediction": lambda: [sl.Prediction.of(12.5), sl.Prediction(1.0, 0.5, 3.0)],
    "PrefilteredMaps": lambda: [
        sl.prefiltered_maps(
            sl.View(*view(), size=SIZE),
            "lispsm",
            resolution=64,
            kernel=kernel,
            renderer="cpu",
            progress=False,
            formats=["depth:pcf", "variance:f16"],
        )
        for kernel in (1, 3)
    ],
    "Preset": lambda: [sl.preset("godot"), sl.preset("filament"), preset_of_ones_own()],
    "ReceiversBody": lambda: [
        importlib.import_module("shadowlab.techniques.presets").receivers_body(*view()),
        importlib.import_module("shadowlab.techniques.presets").ReceiversBody(1, 2, 3, 4, 5, 6, -0.0),
    ],
    "Report": lambda: [sl.report()],
    "Run": lambda: [
        sl.evaluate(sl.View(*view(), size=SIZE), name, resolution=64, renderer="cpu") for name in ("uniform", "lispsm")
    ],
    "Samples": samples,
    "Scene": lambda: [
        small_scene(),
        small_scene().transformed(np.diag([2.0, 2, 2, 1])),
        sl.Scene(view()[0]),
        leafy_scene(),
    ],
    "Limits": lambda: [sl.Limits(), sl.Limits(size=10_000_000, ratio=20.5)],
    "SmallestBias": lambda: [
        sl.smallest_bias(
            sl.View(*view(), size=SIZE), "lispsm", part, resolution=64, renderer="cpu", progress=False, acne=acne
        )
        for part, acne in (("slope", 0.0), ("world", 0.01))
    ],
    "SoftError": lambda: [
        sl.aliasing.soft_error(np.array([[1.0, PAYLOAD_32, -0.0]], np.float32), [[1 / 3, 0.5, 0.0]]),
        sl.aliasing.soft_error([[1.0]], [[0.5]]),
    ],
    "Source": lambda: [
        importlib.import_module("shadowlab.scene.source").Source.of_scene(scene) for scene in (small_scene(), view()[0])
    ],
    "SpotLight": lambda: [
        sl.SpotLight((0, 5, -0.0), (0.1, -1, 0.3), cone_angle=angle, range=20) for angle in (0.5, 1.0)
    ],
    "Stored": lambda: [
        sl.Stored(),
        sl.Stored("back"),
        sl.Stored("dual", limit=np.inf),
        sl.Stored("dual:limit=0.25"),
        sl.Stored("second:spacing=linear,format=unorm16"),
        sl.Stored(format="f16"),
    ],
    "Study": lambda: [studies()],
    "Summary": lambda: [one.summary(bands=2) for one in footprints()[:2]],
    "Technique": lambda: [
        sl.technique("uniform"),
        sl.technique("lispsm"),
        sl.technique("lispsm", near=0.1, near_factor=1 / 3),
        sl.technique("plane_optimal", plane=(0, 1, -0.0, 0.5), fallback="uniform"),
        sl.technique("z_partition", distances=(1, 2.5), inner=["lispsm:near=optimal", "uniform"]),
        sl.technique("z_partition", stable=True),
    ],
    "Temporal": lambda: [
        sl.aliasing.temporal(
            view()[0],
            [view()[1], view()[1].replace(eye=view()[1].eye + 0.1)],
            view()[2],
            ["uniform"],
            resolution=64,
            size=SIZE,
            progress=False,
        )
    ],
    "TemporalFit": lambda: [held(0), held(2), sl.TemporalFit("lispsm", 1.25, np.inf)],
    "Usage": lambda: [
        sl.aliasing.usage(judged()[3], *view()[1:], parameterization(name)) for name in ("uniform", "lispsm")
    ],
    "View": lambda: [
        sl.View(*view(), size=SIZE, label="noon"),
        sl.View(*view()[:2], [view()[2], sl.PointLight((0, 9, 0), range=99)]),
    ],
    "Worst": lambda: [
        closed_form.worst(near=1, far=100, technique="psm"),
        closed_form.worst(near=1, far=np.array([10.0, 100.0]), technique="lispsm"),
    ],
}


def held(frames: int) -> Any:
    """A fit that has held maps for so many frames."""
    fit = sl.TemporalFit(slack=1.5)
    for _ in range(frames):
        fit.parameterize(*view(), resolution=64)
    return fit


def chosen(scene: Any, camera: Any, light: Any) -> tuple[Any, Any]:
    """A choice that can be imported, as a preset of one's own needs."""
    return sl.technique("uniform"), camera


def preset_of_ones_own() -> Any:
    return sl.preset("godot").__class__("mine", "my engine 1.0", "none", "here", "nothing", chosen)


@functools.cache
def examples(name: str) -> list[Any]:
    """The examples of a class, made once."""
    if name in vars(sl.errors):
        return [getattr(sl.errors, name)("what came and what to do")]
    return EXAMPLES[name]()


def bits(thing: Any) -> Any:
    """Everything that can be read of an object, floats and arrays as bytes; equal only for the same bits."""
    if isinstance(thing, float):
        return struct.pack("<d", thing)
    if isinstance(thing, np.ndarray) and thing.dtype != object:
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, (list, tuple, np.ndarray)):
        return [bits(item) for item in thing]
    if isinstance(thing, Mapping):
        return [(name, bits(value)) for name, value in thing.items()]
    if hasattr(thing, "iloc"):
        return list(thing.columns), [bits(thing[column].to_numpy()) for column in thing.columns]
    if isinstance(thing, enum.Enum):
        return type(thing), thing.name
    if isinstance(thing, BaseException):
        return type(thing), thing.args
    if dataclasses.is_dataclass(thing) and not isinstance(thing, type):
        return [(f.name, bits(getattr(thing, f.name))) for f in dataclasses.fields(thing) if f.compare]
    if type(thing).__module__.split(".")[0] == "shadowlab":
        found = []
        for cls in type(thing).__mro__:
            for name, member in sorted(vars(cls).items(), key=lambda entry: entry[0]):
                # What it takes on the heap depends on how it was made.
                if isinstance(member, types.GetSetDescriptorType) and name not in ("__dict__", "memory"):
                    try:
                        found.append((name, bits(getattr(thing, name))))
                    except sl.errors.ArgumentError as refused:  # the matrix of several maps
                        found.append((name, str(refused)))
        return found, bits(vars(thing)) if hasattr(thing, "__dict__") else None
    return type(thing), repr(thing)


def there_and_back(values: list[Any]) -> tuple[list[Any], list[str], list[Any]]:
    """What a worker returns of values: themselves, hashes of scenes, and bits as the worker reads them."""
    hashes = [value.content_hash for value in values if isinstance(value, _core.Scene)]
    return values, hashes, [bits(value) for value in values]


def fitted(technique: Any, scene: Any, camera: Any, light: Any) -> Any:
    """The work of a study: maps of a technique."""
    return technique.parameterize(scene, camera, light, resolution=64)
