"""Which technique at which resolution, with how many splits, at equal memory: ranked over cameras and lights.

Each candidate gets the largest square maps that fit into the budget, is drawn in every view and held against traced
truth, and measured by the footprint of its texels. The numbers of every run are in `Advice.runs`, what they come to in
`Advice.table`, and `Advice.reproduce` gives the Python that computes any row of either again.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Literal

from ..scene.source import Source
from ..techniques.variant import MapReading
from ..text.checks import checked_blend, checked_stored, renderer_of
from ..text.progress import checked_progress, steps_of_call
from .advice import Advice
from .arguments import check_types, checked_source, size_of
from .candidates import Draw, candidates_of, outcomes_of, planned
from .measures import ErrorName, Over, measure_of, over_of
from .memory import DEFAULT_MEMORY, budgets_of
from .noise import outcomes_with_noise
from .phases import PHASES, checked_phases
from .screening import MOST_DRAWN, Predict, checked_predict, chosen_predict, shortlisted
from .tried import untried_of
from .views import views_of

if TYPE_CHECKING:
    from .._core import Bias, Camera, Scene, Stored
    from ..types import Filter, Labelled, Light, RendererArgument, Techniques


def advise(
    scene: Scene,
    cameras: Labelled[Camera],
    lights: Labelled[Light],
    *,
    memory: float | str | Iterable[float | str] = DEFAULT_MEMORY,
    techniques: Techniques | None = None,
    error: ErrorName = "misclassified",
    over: Over = "mean",
    size: tuple[int, int] | None = None,
    renderer: RendererArgument = None,
    bias: Bias | None = None,
    filter: Filter = "nearest",
    blend: float = 0.0,
    stored: Stored | str | None = None,
    phases: int = PHASES,
    predict: Predict | Literal["auto"] | None = "auto",
    drawn: int = MOST_DRAWN,
    progress: bool | None = None,
    source: Source | None = None,
) -> Advice:
    """Which technique, at which resolution and with how many splits, is best at equal memory, and where that switches.

    Parameters
    ----------
    scene : Scene
    cameras : Camera, sequence of them, or dict
        A dict gives each its label.
    lights : DirectionalLight, SpotLight or PointLight, sequence of them, or dict
        Every camera is taken with every light. Without labels lights are called by their elevation and their angle to
        the view. Of one kind, best: lights of several kinds share the resolution of that with most maps.
    memory : int, str, or several
        Bytes of depth texels, 4 each: a number, "4 MiB" (2^20), "16 MB" (10^6). Each candidate gets the largest square
        maps of whole texels that fit in the view where it has most of them; the table has what that leaves unused.
        4 MiB where none is given: one map of 1024 x 1024 texels, the default of `compare` and `evaluate`.
    techniques : sequence or dict, optional
        As of `compare`. Every technique that serves all lights, with its settings that matter (`tried.SETTINGS`), where
        none are given: 2, 3 and 4 depth splits of uniform and of LiSPSM among them. Matrices serve a single view.
    error : str
        What is ranked by: "misclassified" (share of the compared pixels that are wrong), or of the length of a texel
        in the image "worst" (one pixel decides it: "p95" is the one to use), "p95", "mean" (pixels), "undersampled"
        (share), "perspective" (pixels).
    over : str
        How views are put together: "mean" or "worst".
    size : (int, int), optional
        Pixels of the picture, of every camera. About 1024 * 1024 of the camera's aspect where none is given.
    renderer : Renderer or str, optional
        As of `compare`.
    bias : Bias, optional
    filter : str
        One of `sl.filters()`, with its settings.
    blend : float
        The share over which maps blend, as of `evaluate`.
    stored : Stored or str, optional
        What the maps store; the nearest depth as it is where none is given. The memory counts 4 bytes a texel whatever
        its format.
    phases : int
        Shifts of the texels by parts of a texel over which wrong pixels are counted, of the candidates alone between
        which the verdict has to decide; 1 for none. Their `error` is the mean. Texel lengths have no such noise.
    predict : callable, "auto" or None
        ``predict(view, technique, *, resolution)`` foretells wrong pixels without drawing. With each budget the
        `drawn` candidates that it puts first are drawn, beside uniform. "auto" is `shadowlab.predict` with the
        `bias` where no techniques are named and wrong pixels are ranked by; it does not know `filter`, `blend` and
        `stored`. None draws all.
    drawn : int
        Candidates drawn with each budget where there is a prediction.
    progress : bool, optional
        Whether to show a progress bar; on terminals and in notebooks where nothing is given, True anywhere.
    source : Source, optional
        Where the scene came from; see `shadowlab.Source`.

    Returns
    -------
    Advice

    Raises
    ------
    ArgumentError
        For arguments of another type, no view, no candidate, a memory that is no number or holds no map, matrices for
        several views. All before any work.
    UnknownNameError
        For an error, technique, filter, renderer or unit that does not exist. What a technique cannot do with this
        scene or a light is told in its rows.

    Examples
    --------
    >>> import shadowlab as sl
    >>> scene = sl.library.scene("robots")
    >>> lights = {"noon": sl.DirectionalLight((0.1, -1, 0.1)), "evening": sl.DirectionalLight((-1, -0.2, 0.3))}
    >>> advice = sl.advise(scene, scene.camera, lights, memory="64 KiB", techniques=["uniform", "lispsm"],
    ...     size=(160, 90), renderer="cpu", progress=False)
    >>> advice.best.candidate
    'lispsm'
    """
    from .._core import Bias, Camera, DirectionalLight

    # Cameras and lights are checked one by one, with the names that they have here.
    check_types(scene, Camera.look_at((0, 0, 1), (0, 0, 0)), DirectionalLight((0, -1, 0)), bias, filter)
    checked_progress(progress), checked_source(source)
    measure, over = measure_of(error), over_of(over)
    checked_phases(phases)
    named = techniques is not None
    budgets = budgets_of(memory)
    views = views_of(scene, cameras, lights, lambda camera: size_of(size, camera))
    candidates = candidates_of(techniques, views)
    renderer = renderer_of(renderer)
    read = MapReading(Bias() if bias is None else bias, filter, checked_blend(blend), checked_stored(stored))
    draw = Draw(renderer, read, measure)
    foretell = chosen_predict(predict, renderer, read.bias, screens=not named and bool(measure.population))
    drawn = checked_predict(foretell, drawn)
    predictions = len(budgets) if foretell is not None else 0
    with steps_of_call(len(candidates) * (1 + predictions), progress) as step:
        plans = planned(draw, candidates, views, budgets, step)
        plans, worse = shortlisted(plans, views, foretell, drawn, step)
    with steps_of_call(len(views) * (2 + len(plans)), progress) as step:
        outcomes, filled = outcomes_of(draw, plans, views, step)
    if measure.population:
        with steps_of_call(len(outcomes), progress) as step:
            outcomes = outcomes_with_noise(outcomes, over, phases, step)
    untried = [*untried_of({one.technique for one in candidates}, {view.light.kind for view in views}), *worse]
    return Advice(
        tuple(outcomes), tuple(candidates), tuple(views), tuple(budgets), measure, over, read.bias, filter,
        renderer.backend, renderer.adapter, filled,
        source or Source.of_scene(scene), tuple(untried), phases, renderer, read.blend, read.stored,
    )  # fmt: skip
