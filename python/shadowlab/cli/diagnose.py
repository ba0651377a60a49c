"""The command `shadowlab diagnose`: what sets two shadow matrices apart."""

from __future__ import annotations

from pathlib import Path

import click

from .command import Argument, Command, Options
from .options import light_option, one_resolution, resolution_option, scene_argument, size_given, view_options
from .view import load_view


def diagnose_command(options: Options) -> int:
    """Says what sets two shadow matrices apart. Exit status 0 where both are one map, however written, else 1."""
    from ..conventions.diagnosis import diagnose
    from ..conventions.files import matrix_technique, read

    resolution = one_resolution(options)
    mine = matrix_technique(f"matrix:file={options.mine}", {"file": options.mine})
    scene = camera = None
    if options.scene is not None:
        scene, camera, _, _ = load_view(options, size_given(options))
    theirs = read(Path(options.theirs))["matrix"]
    found = diagnose(mine, theirs, camera=camera, scene=scene, resolution=resolution)
    left = f"{found.texels:.6g} texels, {found.depth:.6g} of depth"
    whose = "" if found.side == "theirs" else f" of {found.side}"
    print(f"{found}\nconvention{whose}: {found.convention}\nlargest difference: {left}")
    return 0 if found.same else 1


DIAGNOSE = Command(
    "diagnose",
    diagnose_command,
    [
        Argument(
            "mine", metavar="MINE", type=click.Path(),
            help="npy, json or text, in this program's convention or as json says",
        ),
        Argument("theirs", metavar="THEIRS", type=click.Path(), help="npy, json or text, in any convention"),
        scene_argument(required=False),
        resolution_option("texels along each side"),
        light_option(),
        *view_options(),
    ],
)  # fmt: skip
