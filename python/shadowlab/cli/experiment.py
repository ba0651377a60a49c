"""The command `shadowlab experiment`: published experiments, made again and checked."""

from __future__ import annotations

from ..text import counted, parse_resolutions
from .command import Command, Commands, Option, Options
from .options import backend_option, directory_option, technique_option, writable_directory

BOUND_FAILED = 1


def scene_optimal_command(options: Options) -> int:
    """Counts wrong pixels of techniques at equal memory, against traced truth and against a large normal map.

    The normal map is the smallest rectangle around what the light reaches of the view frustum; one of 3700 x 3700
    texels is what the paper takes for the truth. Exit status 1 where the normal map does not make as many more mistakes
    than the optimized ones as the bounds say.
    """
    from ..experiments import scene_optimal as experiment
    from ..experiments import scene_optimal_table, scene_optimal_views

    quick = options.quick
    of_kind: tuple[int, ...] = experiment.QUICK_SIZES if quick else experiment.SIZES
    sizes = of_kind if options.sizes is None else parse_resolutions(options.sizes)
    techniques = options.technique or (experiment.QUICK_TECHNIQUES if quick else experiment.TECHNIQUES)
    views = scene_optimal_views.configurations()
    names = options.configuration or (scene_optimal_views.QUICK if quick else None)
    chosen = views if names is None else experiment.chosen_views(names, views)
    directory = writable_directory(options.out)
    result = experiment.scene_optimal_experiment(
        techniques, sizes=sizes, views=chosen, renderer=options.backend, out=directory
    )
    print(f"{counted(len(chosen), 'configuration')} on {result.backend} ({result.adapter})\n\n{result}\n")
    print(f"Tables and figures: {result.save(directory)}")
    if options.configuration or options.sizes:
        return 0  # bounds are of all configurations and sizes
    bounds = {name: least for name, least in scene_optimal_table.BOUNDS.items() if name in result.techniques}
    failed = result.failed_bounds(bounds)
    held = [f"{name} at least {least:g} %" for name, least in bounds.items()]
    print("\n".join(failed or [f"Bounds hold: {'; '.join(held) or 'none, as their techniques were not counted'}"]))
    return BOUND_FAILED if failed else 0


SCENE_OPTIMAL = Command(
    "scene-optimal",
    scene_optimal_command,
    [
        Option("--quick", is_flag=True, help="four configurations, one size and five techniques: about a minute"),
        Option(
            "--sizes", metavar="N[,N...]", help="texels along each side of a single map (default: 750,1000,...,2000)"
        ),
        technique_option(
            "repeat for several; the normal map is always counted; a technique with K maps has maps of N / sqrt(K) "
            "texels a side (default: those of docs/scene_optimal.md)"
        ),
        Option(
            "--configuration",
            multiple=True,
            metavar="CAMERA|LIGHT|'CAMERA, LIGHT'",
            help="repeat for several; docs/scene_optimal.md lists them (default: all 28)",
        ),
        backend_option(),
        directory_option("scene_optimal", "tables and figures, and rows that are not made again,"),
    ],
)
EXPERIMENT = Commands(
    "experiment",
    {
        "scene-optimal": (
            "wrong pixels at equal memory in 28 configurations of the scene @statues (Chong, Gortler 2007)",
            lambda: SCENE_OPTIMAL,
        )
    },
    kind="EXPERIMENT",
    help="Published experiments, made again.",
)
