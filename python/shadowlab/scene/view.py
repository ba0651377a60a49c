"""What a shadow is looked at in: a scene, a camera and its picture, and a light."""

from __future__ import annotations

import time
from collections.abc import Hashable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal, TypeAlias, cast, get_args

import numpy as np
from numpy.typing import NDArray

from .. import _core
from ..errors import ArgumentError
from ..text.checked import a_text, a_word, one_or_more_lights
from ..text.checks import check_camera, check_scene, picture_of, renderer_of, whole
from ..travel import Value
from .gaps import traced_gaps
from .kept import Kept
from .light_way import angle_to, elevation_of, light_way
from .origin import SceneOrigin
from .source import Source

if TYPE_CHECKING:
    from ..types import Light, PerLight, RendererArgument, RendererLike, Size, TruthImage

# G-buffers and truths of the views that were used last: 20 pictures of 1024 x 1024 pixels with their truths.
KEPT_VIEWS = Kept(1 << 30)
# Of a G-buffer: depth, relative position, normal, triangle, instance (36), and world positions in f64 where asked for.
GBUFFER_BYTES_PER_PIXEL = 60
# Of samples: position and normal, which the lights of a view share; of each light its states and those in shadow.
SAMPLE_BYTES = 24
STATE_BYTES = 6
SAMPLE_COUNT = 4096
ShadowSource: TypeAlias = Literal["mapped", "traced"]
SHADOW_SOURCES = (*get_args(ShadowSource), None)


@dataclass(frozen=True, eq=False)
class View(Value):
    """A scene as a camera sees it under a light: what every evaluation is of.

    What the camera sees and the traced truth are made at the first use and kept, for all equal views together, while
    there is room.

    Parameters
    ----------
    scene : Scene
    camera : Camera
    light : DirectionalLight, SpotLight or PointLight, or sequence of them
        Several lights are evaluated each for itself; see `views`.
    size : int, (int, int) or None
        Width and height of the picture in pixels. None takes about 1024 * 1024 square pixels of the camera's aspect.
    label : str
        Its name in tables.

    Raises
    ------
    ArgumentError
        For arguments of another type, no light, or a size that is not two whole numbers above 0.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90), label="noon")
    >>> view.truth().shape
    (90, 160)
    """

    scene: _core.Scene
    camera: _core.Camera
    light: Light | tuple[Light, ...]
    size: tuple[int, int] = (1024, 1024)
    label: str = ""

    if TYPE_CHECKING:
        # What may be given is more than what is kept.
        def __init__(
            self,
            scene: _core.Scene,
            camera: _core.Camera,
            light: Light | Iterable[Light],
            size: Size | None = (1024, 1024),
            label: str = "",
        ) -> None: ...

    def __post_init__(self) -> None:
        check_scene(self.scene)
        check_camera(self.camera)
        object.__setattr__(self, "light", one_or_more_lights("light", self.light))
        object.__setattr__(self, "size", picture_of(self.size, self.camera))
        a_text("label", self.label)

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> object:
            origin = self.__dict__.get("_origin")
            if name != "scene" or origin is None:
                raise AttributeError(f"{type(self).__name__!r} object has no attribute {name!r}")
            object.__setattr__(self, "scene", origin.scene)
            return self.scene

    @property
    def origin(self) -> SceneOrigin:
        """Where its scene came from, and what it was."""
        known = self._known_scene
        return known if isinstance(known, SceneOrigin) else SceneOrigin.of_scene(known)

    @property
    def scene_name(self) -> str:
        """What tables call its scene."""
        known = self._known_scene
        return known.name if isinstance(known, SceneOrigin) else Source.of_scene(known).name

    def __eq__(self, other: object) -> bool:
        # By the hash of the scene, so that one that is not there need not be made.
        if not isinstance(other, View):
            return NotImplemented
        return self is other or self._content == other._content

    def __hash__(self) -> int:
        return hash(self._content)

    @property
    def lights(self) -> tuple[Light, ...]:
        """The lights, one or several."""
        return self.light if isinstance(self.light, tuple) else (self.light,)

    @property
    def views(self) -> tuple[View, ...]:
        """A view per light; they share the G-buffer."""
        if not isinstance(self.light, tuple):
            return (self,)
        names = [f"{self.label}, light {i + 1}" if self.label else f"light {i + 1}" for i in range(len(self.light))]
        return tuple(replace(self, light=one, label=name) for one, name in zip(self.light, names, strict=True))

    def gbuffer(self, renderer: RendererArgument = None) -> _core.GBuffer:
        """What the camera sees, made once by each renderer and kept.

        Parameters
        ----------
        renderer : Renderer or str, optional
            As of `compare`; the best there is where none is given.
        """
        draw = renderer_of(renderer)
        width, height = self.size
        return KEPT_VIEWS.get(
            self._seen,
            ("gbuffer", *identity_of(draw)),
            lambda: draw.gbuffer(self.scene, self.camera, size=self.size),
            lambda _: GBUFFER_BYTES_PER_PIXEL * width * height,
        )

    def samples(
        self,
        size: Size | None = None,
        shadows: ShadowSource | None = "mapped",
        count: int = SAMPLE_COUNT,
        *,
        renderer: RendererArgument = None,
    ) -> PerLight[_core.Samples]:
        """What the camera sees as points: what techniques make their maps for. Made once and kept.

        The hull of a map comes from every pixel; the samples at the edges of shadows, which a search looks at, are
        thinned evenly and without chance.

        Parameters
        ----------
        size : int or (int, int), optional
            Width and height of the picture that the samples come from, pixels; the view's own G-buffer where none is
            given, so that no visible receiver is missed.
        shadows : {"mapped", "traced"} or None
            Where shadow states come from: one uniform map of 1024 x 1024 texels over the receivers' body, which is what
            an engine has; or rays, the laboratory's upper bound; or nowhere, which is enough for ``fit="seen"``.
        count : int
            Samples at the edges of shadows that are kept.
        renderer : Renderer or str, optional
            As of `gbuffer`.

        Returns
        -------
        Samples, or tuple of them
            One per light where `light` is a sequence.

        Raises
        ------
        ArgumentError
            For sizes and counts that are none, and another word for `shadows`.

        References
        ----------
        Chong, Gortler 2007 (scene-optimized shadow maps): samples near shadow edges.

        Examples
        --------
        >>> import shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> view = sl.View(scene, scene.camera, scene.light, size=(160, 90))
        >>> samples = view.samples()
        >>> samples.positions.shape == (len(samples), 3)
        True
        """
        a_word(SHADOW_SOURCES, "mapped is what an engine has")("shadows", shadows)
        if isinstance(self.light, tuple):
            return tuple(view._sampled(size, shadows, count, renderer)[0] for view in self.views)
        return self._sampled(size, shadows, count, renderer)[0]

    def samples_ms(self, renderer: RendererArgument = None) -> float:
        """Milliseconds that making the `samples` of all lights took when they were made, G-buffer aside."""
        return sum(view._sampled(None, "mapped", SAMPLE_COUNT, renderer)[1] for view in self.views)

    def truth(self) -> PerLight[TruthImage]:
        """The traced truth, made once and kept.

        Returns
        -------
        (H, W) int8, or tuple of them
            As of `trace.shadow_mask`: 1 lit, 0 in shadow, -1 undecided, -2 nothing there. One per light where `light`
            is a sequence. Read-only, since it is shared.
        """
        traced = self._traced()
        return tuple(truth for truth, _ in traced) if isinstance(self.light, tuple) else traced[0][0]

    @property
    def truth_ms(self) -> float:
        """Milliseconds that tracing the truth of all lights took when it was traced."""
        return sum(ms for _, ms in self._traced())

    def filled(self, renderer: RendererArgument = None) -> float:
        """Share of the picture's pixels that show a surface."""
        return float(np.mean(np.asarray(self.gbuffer(renderer).triangle) >= 0))

    @property
    def light_angle(self) -> float | None:
        """Angle between the way that the light travels and the view, radians; None without a way, or several lights."""
        return (
            None if isinstance(self.light, tuple) else angle_to(light_way(self._known_scene, self.light), self.camera)
        )

    @property
    def light_elevation(self) -> float | None:
        """How high the light stands above the horizon (y points up), radians; None as of `light_angle`."""
        return None if isinstance(self.light, tuple) else elevation_of(light_way(self._known_scene, self.light))

    def clear(self) -> None:
        """Forgets what is kept of this picture, for all its lights."""
        KEPT_VIEWS.forget(self._seen)

    def _repr_html_(self) -> str:
        from ..reports.html.values import view_html

        return view_html(self)

    @property
    def _seen(self) -> tuple[Hashable, ...]:
        return (self._known_scene.content_hash, self.camera, self.size)

    @property
    def _content(self) -> tuple[Hashable, ...]:
        return (*self._seen, self.light, self.label)

    @property
    def _known_scene(self) -> _core.Scene | SceneOrigin:
        """The scene, or what is known of one that is not there; both have its bounds and its content hash."""
        known: SceneOrigin | None = self.__dict__.get("_origin")
        return self.scene if known is None else known

    def _sampled(
        self, size: Size | None, shadows: ShadowSource | None, count: int, renderer: RendererArgument
    ) -> tuple[_core.Samples, float]:
        draw, light = renderer_of(renderer), light_of(self)
        whole("count", count)
        own = size is None
        pixels = self.size if size is None else picture_of(size, self.camera)

        def make() -> tuple[_core.Samples, float]:
            gbuffer = self.gbuffer(draw) if own else draw.gbuffer(self.scene, self.camera, size=pixels)
            start = time.perf_counter()
            unlit = self._unlit_samples(draw) if own else _core.Samples.from_gbuffer(gbuffer, self.camera)
            if shadows is None:
                return unlit, 1e3 * (time.perf_counter() - start)
            if shadows == "mapped":
                states = _core.mapped_states(self.scene, self.camera, light, gbuffer)
            else:
                states = cast("NDArray[np.int8]", replace(self, size=pixels).truth())
            made = _core.samples_under(unlit, gbuffer, light, states, count)
            return made, 1e3 * (time.perf_counter() - start)

        key = ("samples", self.light, pixels, shadows, count, *identity_of(draw))
        each = STATE_BYTES if own else SAMPLE_BYTES + STATE_BYTES
        return KEPT_VIEWS.get(self._seen, key, make, lambda made: each * made[0].receivers)

    def _unlit_samples(self, draw: RendererLike) -> _core.Samples:
        """The pixels of the view as samples that know no shadows, made once for all lights."""
        return KEPT_VIEWS.get(
            self._seen,
            ("unlit samples", *identity_of(draw)),
            lambda: _core.Samples.from_gbuffer(self.gbuffer(draw), self.camera),
            lambda made: SAMPLE_BYTES * made.receivers,
        )

    def gaps(
        self, shadows: ShadowSource = "mapped", *, renderer: RendererArgument = None
    ) -> PerLight[NDArray[np.float32]]:
        """How far before what each pixel shows, towards the light, what shades it lies. Made once and kept.

        Parameters
        ----------
        shadows : "mapped" or "traced"
            As of `samples`.
        renderer : Renderer or str, optional
            As of `gbuffer`.

        Returns
        -------
        (H, W) float32, or tuple of them
            World units along the light's ray to what the light meets first; 0 where the pixel is lit, faces away from
            the light or shows nothing. One per light where `light` is a sequence. Read-only, since it is shared.

        Raises
        ------
        UnknownNameError
            For another word for `shadows`.

        Examples
        --------
        >>> import shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> gaps = sl.View(scene, scene.camera, scene.light, size=(160, 90)).gaps()
        >>> gaps.shape, bool(gaps.max() > 0)
        ((90, 160), True)
        """
        a_word(SHADOW_SOURCES[:-1], "mapped is what an engine has")("shadows", shadows)
        found = tuple(view._gaps(shadows, renderer) for view in self.views)
        return found if isinstance(self.light, tuple) else found[0]

    def _gaps(self, shadows: ShadowSource, renderer: RendererArgument) -> NDArray[np.float32]:
        draw, light = renderer_of(renderer), light_of(self)

        def make() -> NDArray[np.float32]:
            if shadows == "traced":
                made = traced_gaps(self.scene, light, self.gbuffer(draw), cast("TruthImage", self.truth()))
            else:
                made = _core.mapped_gaps(self.scene, self.camera, light, self.gbuffer(draw))
            made.flags.writeable = False
            return made

        key = ("gaps", self.light, shadows, *identity_of(draw))
        return KEPT_VIEWS.get(self._seen, key, make, lambda made: made.nbytes)

    def _traced(self) -> tuple[tuple[NDArray[np.int8], float], ...]:
        """The truth of each light, and the milliseconds that it took."""

        def trace(lights: Sequence[Light]) -> dict[Light, tuple[NDArray[np.int8], float]]:
            start = time.perf_counter()
            if len(lights) == 1:
                truths = [_core.trace_shadow_mask(self.scene, self.camera, lights[0], size=self.size)]
            else:
                truths = _core.trace_shadow_masks(self.scene, self.camera, lights, size=self.size)
            each_ms = 1e3 * (time.perf_counter() - start) / len(lights)
            for truth in truths:
                truth.flags.writeable = False
            return {light: (truth, each_ms) for light, truth in zip(lights, truths, strict=True)}

        # Lights that are traced together share the rays from the eye.
        missing = [light for light in dict.fromkeys(self.lights) if not KEPT_VIEWS.holds(self._seen, ("truth", light))]
        made = trace(missing) if len(missing) > 1 else {}

        def kept(light: Light) -> tuple[NDArray[np.int8], float]:
            return KEPT_VIEWS.get(
                self._seen,
                ("truth", light),
                lambda: made[light] if light in made else trace([light])[light],
                lambda one: one[0].nbytes,
            )

        return tuple(kept(light) for light in self.lights)


def view_of_origin(
    origin: SceneOrigin, camera: _core.Camera, light: Light | tuple[Light, ...], size: tuple[int, int], label: str
) -> View:
    """A view of a scene that is made again when it is needed: for pictures, not for numbers."""
    made = object.__new__(View)
    fields = {"camera": camera, "light": light, "size": size, "label": label, "_origin": origin}
    for name, value in fields.items():
        object.__setattr__(made, name, value)
    return made


def light_of(view: View) -> Light:
    """The light of a view with one.

    Raises
    ------
    ArgumentError
        For several.
    """
    if isinstance(view.light, tuple):
        raise ArgumentError(f"view: expected one light, got {len(view.light)}; call it for each of view.views")
    return view.light


class _Itself:
    """An object as a key: equal to itself alone, whatever it says of others, and alive as long as the key."""

    def __init__(self, of: object) -> None:
        self.of = of

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Itself) and other.of is self.of

    def __hash__(self) -> int:
        return id(self.of)


def identity_of(renderer: RendererLike) -> tuple[Hashable, ...]:
    """What tells a renderer's pictures from another's: backend and adapter of ours, the object itself of others.

    None of ours is kept alive by it: each has memory of its own on the device, which nothing would count.
    """
    if not isinstance(renderer, _core.Renderer):
        return (_Itself(renderer),)
    # The processor draws the same with any number of threads, which its adapter names.
    return ("cpu",) if renderer.backend == "cpu" else (renderer.backend, renderer.adapter)


def checked_view(view: object) -> View:
    """The view.

    Raises
    ------
    ArgumentError
        For anything else.
    """
    if isinstance(view, View):
        return view
    raise ArgumentError(f"view: expected a View, got {type(view).__name__}; sl.View(scene, camera, light) makes one")
