"""The command `shadowlab experiment`: published experiments, made again and checked."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from typing import TYPE_CHECKING

from ..text import parse_resolutions
from ..text.checks import BACKENDS
from .options import directory_option, technique_option, writable_directory

if TYPE_CHECKING:
    from .options import Commands

BOUND_FAILED = 1


def experiment_options(commands: Commands, shared: ArgumentParser) -> None:
    """Adds the command with its experiments to the others."""
    experiment = commands.add_parser(
        "experiment",
        parents=[shared],
        help="published experiments, made again",
        description="Published experiments, made again.",
    )
    experiments: Commands = experiment.add_subparsers(
        metavar="EXPERIMENT", required=True, parser_class=type(experiment)
    )
    one = experiments.add_parser(
        "scene-optimal",
        parents=[shared],
        help="wrong pixels at equal memory in 28 configurations of the scene @statues (Chong, Gortler 2007)",
        description=scene_optimal_command.__doc__,
    )
    one.add_argument(
        "--quick", action="store_true", help="four configurations, one size and five techniques: about a minute"
    )
    one.add_argument(
        "--sizes", metavar="N[,N...]", help="texels along each side of a single map (default: 750,1000,...,2000)"
    )
    technique_option(
        one,
        "repeat for several; the normal map is always counted; a technique with K maps has maps of N / sqrt(K) texels "
        "a side (default: those of docs/scene_optimal.md)",
    )
    one.add_argument(
        "--configuration",
        action="append",
        metavar="CAMERA|LIGHT|'CAMERA, LIGHT'",
        help="repeat for several; docs/scene_optimal.md lists them (default: all 28)",
    )
    one.add_argument("--backend", default="auto", choices=BACKENDS, help="the renderer (default: auto)")
    directory_option(one, "scene_optimal", "tables and figures, and rows that are not made again,")
    one.set_defaults(run=scene_optimal_command)


def scene_optimal_command(options: Namespace) -> int:
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
    many = "" if len(chosen) == 1 else "s"
    print(f"{len(chosen)} configuration{many} on {result.backend} ({result.adapter})\n\n{result}\n")
    print(f"Tables and figures: {result.save(directory)}")
    if options.configuration or options.sizes:
        return 0  # bounds are of all configurations and sizes
    bounds = {name: least for name, least in scene_optimal_table.BOUNDS.items() if name in result.techniques}
    failed = result.failed_bounds(bounds)
    held = [f"{name} at least {least:g} %" for name, least in bounds.items()]
    print("\n".join(failed or [f"Bounds hold: {'; '.join(held) or 'none, as their techniques were not counted'}"]))
    return BOUND_FAILED if failed else 0
