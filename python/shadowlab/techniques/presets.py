"""What engines ship, as data: each engine's warp distance or split depths with its source, on our body and our fit.

An engine's shadow map is a formula for the warp or the splits, a body to fit and a way to fit it. The formula is the
engine's own here, as its source has it; the body and the fit are ours for all, so that a comparison isolates the
formula. To hold an engine's exact matrices against ours, hand them over: `Parameterization.from_matrix` and `diagnose`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeAlias

from .. import _core
from ..errors import UnknownNameError, UnsupportedError
from ..text import shown
from ..text.checked import A_CAMERA, A_SCENE, a_light, a_text, checked
from ..travel import Value

if TYPE_CHECKING:
    import pandas as pd

    from ..types import Light


@dataclass(frozen=True, eq=False)
class ReceiversBody(Value):
    """What the formulas look at: the receivers' body as eye and light see it.

    Attributes
    ----------
    near, far : float
        Camera depths of the body, world units.
    camera_near, camera_far : float
        Camera depths of the clip planes, world units.
    y_min : float
        Where the body begins along the warp axis, from the eye's image, world units.
    extent : float
        Its length along the warp axis, world units.
    sine : float
        Sine of the angle between light and view.
    """

    near: float
    far: float
    camera_near: float
    camera_far: float
    y_min: float
    extent: float
    sine: float


#: Engines fit what the camera's frustum holds of the scene, without a look at what is seen.
BODY: dict[str, Any] = {"range": "body", "fit": "exact"}

#: Of a scene, camera and light the technique with an engine's numbers, and the camera with the engine's clip planes.
Choose: TypeAlias = "Callable[[_core.Scene, _core.Camera, Light], tuple[_core.Technique, _core.Camera]]"


@dataclass(frozen=True, eq=False)
class Preset(Value):
    """An engine's shadows as a technique: `parameterize` works as a `Technique`'s does.

    Attributes
    ----------
    name : str
    engine : str
        Which engine and version.
    formula : str
        The formula as its source has it.
    source : str
        Where it stands: repository and file, function.
    differs : str
        What the engine does otherwise than this preset.
    """

    name: str
    engine: str
    formula: str
    source: str
    differs: str
    choose: Choose

    @property
    def settings(self) -> Mapping[str, Any]:
        """No parameters: a preset is what the engine ships."""
        return {}

    @property
    def needs_samples(self) -> bool:
        """Presets never look at receivers."""
        return False

    @property
    def needs_shadows(self) -> bool:
        """Nor at shadows."""
        return False

    @checked(scene=A_SCENE, camera=A_CAMERA, light=a_light)
    def technique(self, scene: _core.Scene, camera: _core.Camera, light: Light) -> _core.Technique:
        """The technique with the numbers that the engine's formula gives for this view."""
        return self.choose(scene, camera, light)[0]

    @checked(scene=A_SCENE, camera=A_CAMERA, light=a_light)
    def parameterize(
        self,
        scene: _core.Scene,
        camera: _core.Camera,
        light: Light,
        *,
        resolution: int = 1024,
        samples: _core.Samples | _core.GBuffer | None = None,
    ) -> _core.Parameterization:
        """The maps for a scene, camera and light; see `Technique.parameterize`.

        Raises
        ------
        UnsupportedError
            A light that the engine's shadows of this kind do not serve: all presets are for directional lights.
        """
        if not isinstance(light, _core.DirectionalLight):
            raise UnsupportedError(f"preset {self.name!r} serves directional lights, got a {light.kind} light")
        technique, seen = self.choose(scene, camera, light)
        return technique.parameterize(scene, seen, light, resolution=resolution)

    def __reduce__(self) -> tuple[Any, ...]:
        # Those of the table are known by name wherever the package is; `choose` of another is a function of a module.
        return (preset, (self.name,)) if any(entry is self for entry in PRESETS) else super().__reduce__()

    def __repr__(self) -> str:
        return f"Preset({self.name!r}: {self.engine})"


@checked(name=a_text)
def preset(name: str) -> Preset:
    """The preset of that name.

    Raises
    ------
    UnknownNameError
        No such preset; the message lists the valid ones.
    """
    for entry in PRESETS:
        if entry.name == name:
            return entry
    raise UnknownNameError(
        f"name: unknown preset {shown(name)}: expected one of {', '.join(entry.name for entry in PRESETS)}"
    )


def presets() -> pd.DataFrame:
    """One row a preset: name, engine, formula, source, differs."""
    import pandas as pd

    columns = ["name", "engine", "formula", "source", "differs"]
    return pd.DataFrame([[getattr(entry, c) for c in columns] for entry in PRESETS], columns=columns)


def receivers_body(scene: _core.Scene, camera: _core.Camera, light: Light) -> ReceiversBody | None:
    """The body as our LiSPSM sees it; None where there is no warp (the light along the view, nothing seen)."""
    camera = camera.bounded(scene)
    p = _core.Technique("lispsm", near="delta-z", **BODY).parameterize(scene, camera, light, resolution=1024)
    (only,) = p.partitions
    numbers = dict(only.values)
    if "y_min" not in numbers:
        return None
    near, far = only.eye_depth
    return ReceiversBody(near, far, camera.near, camera.far, numbers["y_min"], numbers["depth"], numbers["kappa"])


def filament_near(body: ReceiversBody, near_hint: float = 1.0, far_hint: float = 100.0) -> float:
    """Filament's warp distance; infinite where it draws a uniform map.

    `nopt0 = (z0 + sqrt(vz0 vz1)) / sin`, `nopt1 = dzn / (2 - 3 dzn / (zf - zn))`, and the larger of the two.
    """
    dzn = max(0.0, near_hint - body.camera_near)
    dzf = max(0.0, body.camera_far - far_hint)
    zn, zf = max(body.camera_near, body.near), min(body.camera_far, body.far)
    z0, z1 = zn, zn + body.extent * body.sine
    if body.sine <= 0.02 or zf <= zn or 3.0 * dzn / (zf - zn) >= 2.0:
        return math.inf
    vz0 = max(0.0, zn, body.camera_near + dzn, z0)
    vz1 = max(0.0, min(zf, body.camera_far - dzf, z1))
    return max((z0 + math.sqrt(vz0 * vz1)) / body.sine, dzn / (2.0 - 3.0 * dzn / (zf - zn)))


def ogre_near(body: ReceiversBody, adjust: float = 0.1, threshold: float = 0.9) -> float:
    """OGRE's "simple" warp distance: `(|z| + sqrt(near far)) adjust tweak`.

    The tweak grows from 1 to 21 as the cosine between light and view grows from `threshold` to 1.
    """
    cosine = math.sqrt(max(0.0, 1.0 - body.sine**2))
    tweak = 1.0 + 20.0 * max(0.0, cosine - threshold) / (1.0 - threshold)
    return (body.near + math.sqrt(body.camera_near * body.camera_far)) * adjust * tweak


def openscenegraph_near(body: ReceiversBody) -> float:
    """OpenSceneGraph's warp distance, told from the near end of the body.

    `z_n = near / sin`, `z_f = z_n + d sin`, `n = (z_n + sqrt(z_f z_n)) / sin`; the reference point is `n - near` behind
    the eye.
    """
    z_n = body.near / body.sine
    n = (z_n + math.sqrt((z_n + body.extent * body.sine) * z_n)) / body.sine
    return n - body.near + body.y_min


def bevy_bounds(count: int = 4, first: float = 10.0, maximum: float = 150.0) -> list[float]:
    """Bevy's far bounds of all cascades: geometric from the first to the maximum distance."""
    if count == 1:
        return [maximum]
    return [first * (maximum / first) ** (i / (count - 1)) for i in range(count)]


def godot_distances(near: float, maximum: float, offsets: tuple[float, ...] = (0.1, 0.2, 0.5)) -> list[float]:
    """Godot's split depths: shares of the way from near to the maximum distance."""
    return [near + share * (maximum - near) for share in offsets]


def _warped(near: Callable[[ReceiversBody], float]) -> Choose:
    """LiSPSM with an engine's warp distance; uniform where the engine has none."""

    def choose(scene: _core.Scene, camera: _core.Camera, light: Light) -> tuple[_core.Technique, _core.Camera]:
        body = receivers_body(scene, camera, light)
        distance = math.inf if body is None else near(body)
        if math.isinf(distance):
            return _core.Technique("uniform", **BODY), camera
        # A reference point inside the body (OpenSceneGraph can have one) has no map; the least distance stands for it.
        return _core.Technique("lispsm", near=max(0.0, distance), **BODY), camera

    return choose


def _cascades(
    splits: Callable[[float, float], list[float]],
    maximum: float,
    planes: tuple[float, float] | None = None,
) -> Choose:
    """Stable uniform maps between an engine's split depths, up to its maximum distance.

    Between the camera's near plane and its far plane or the maximum, or between planes that the engine takes instead.
    """

    def choose(scene: _core.Scene, camera: _core.Camera, light: Light) -> tuple[_core.Technique, _core.Camera]:
        near, far = planes or (camera.near, min(camera.far, maximum))
        if camera.near >= maximum:
            raise UnsupportedError(
                f"the engine draws shadows up to a depth of {maximum:g}, the camera sees nothing nearer than "
                f"{camera.near:g}; move its near plane"
            )
        seen = camera if (near, far) == (camera.near, camera.far) else camera.replace(near=near, far=far)
        return _core.Technique("z_partition", distances=splits(near, far), stable=True, range="camera"), seen

    return choose


def three_breaks(near: float, far: float, count: int = 3, share: float = 0.5) -> list[float]:
    """The breaks of three.js: depths as shares of far, a blend of the uniform and the logarithmic scheme, the last 1.

    `share` of the logarithmic one: 0 is the engine's mode "uniform", 1 its "logarithmic", 1/2 its "practical".
    """
    inner = range(1, count)
    uniform = [(near + (far - near) * i / count) / far for i in inner]
    logarithmic = [near * (far / near) ** (i / count) / far for i in inner]
    return [(1.0 - share) * u + share * v for u, v in zip(uniform, logarithmic, strict=True)] + [1.0]


def three_distances(near: float, far: float) -> list[float]:
    """Split depths of three.js: its frustum is cut at the breaks as shares of the way from near to far.

    The breaks are shares of far, so its maps reach further than the scheme's depths, the more the larger near is.
    """
    return [near + (far - near) * share for share in three_breaks(near, far)[:-1]]


PRESETS = (
    Preset(
        "filament",
        "Filament (LightManager::ShadowOptions defaults: one map, lispsm, shadowNearHint 1, shadowFarHint 100)",
        "n = max((z0 + sqrt(vz0 vz1)) / sin, dzn / (2 - 3 dzn / (zf - zn)))",
        "google/filament filament/src/ShadowMap.cpp, ShadowMap::applyLISPSM",
        "fits receivers and casters of its own culling; no warp below a sine of 0.02 (as here)",
        _warped(filament_near),
    ),
    Preset(
        "ogre-1.12", "OGRE 1.12 (LiSPSMShadowCameraSetup defaults: simple n_opt, adjust factor 0.1, threshold 0.9)",
        "n = (|z_e| + sqrt(near far)) 0.1 (1 + 20 max(0, (|cos| - 0.9) / 0.1))",
        "OGRECave/ogre OgreMain/src/OgreShadowCameraSetupLiSPSM.cpp, calculateNOptSimple and getShadowCamera",
        "anchors at the near end of the casters' body, and fits that body",
        _warped(ogre_near),
    ),
    Preset(
        "openscenegraph", "OpenSceneGraph 3.6 (osgShadow, the formula of the authors' code of 2004)",
        "z_n = near / sin; z_f = z_n + d sin; n = (z_n + sqrt(z_f z_n)) / sin; reference point n - near behind the eye",
        "openscenegraph/OpenSceneGraph src/osgShadow/LightSpacePerspectiveShadowMap.cpp",
        "works after a first shadow projection whose scale enters the formula; its reference point can lie in the view",
        _warped(openscenegraph_near),
    ),
    Preset(
        "bevy", "Bevy (CascadeShadowConfigBuilder defaults: 4 cascades, first bound 10, maximum distance 150)",
        "bound_i = first (maximum / first)^(i / (count - 1))",
        "bevyengine/bevy crates/bevy_light/src/cascade.rs, calculate_cascade_bounds",
        "each cascade begins 20 % before the last one's bound, to blend between them; its sides are whole world units",
        _cascades(lambda near, far: bevy_bounds()[:-1], maximum=150.0, planes=(0.1, 150.0)),
    ),
    Preset(
        "three.js", "three.js (examples/jsm/csm/CSM.js defaults: 3 cascades, practical, lambda 0.5)",
        "depth_i = near + (far - near) break_i, "
        "break_i = lerp(near + (far - near) i / m, near (far / near)^(i / m), 0.5) / far",
        "mrdoob/three.js examples/jsm/csm/CSM.js, getBreaks; CSMFrustum.js, split",
        "the light's near and far planes are fixed distances, 1 and 2000; CSM.js reads the map whose breaks hold "
        "depth / (far - near), and none beyond a depth of far - near; CSMShadowNode.js reads the map made for a depth, "
        "as here",
        _cascades(three_distances, maximum=100_000.0),
    ),
    Preset(
        "godot", "Godot 4 (DirectionalLight3D defaults: 4 splits at 0.1, 0.2, 0.5 of 100)",
        "distance_i = near + split_i (maximum - near)",
        "godotengine/godot servers/rendering/renderer_scene_cull.cpp, _light_instance_setup_directional_shadow",
        "casters before the near plane are flattened onto it (pancaking)",
        _cascades(godot_distances, maximum=100.0),
    ),
)  # fmt: skip
