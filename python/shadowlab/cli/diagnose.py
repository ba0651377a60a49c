"""The command `shadowlab diagnose`: what sets two shadow matrices apart."""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from pathlib import Path
from typing import TYPE_CHECKING

from .options import one_resolution, resolution_option, size_given, view_options
from .view import load_view

if TYPE_CHECKING:
    from .options import Commands


def diagnose_options(commands: Commands, shared: ArgumentParser) -> None:
    """Adds the command with its options to the others."""
    diagnose = commands.add_parser(
        "diagnose",
        parents=[shared],
        help="what sets two shadow matrices apart",
        description=diagnose_command.__doc__,
    )
    diagnose.add_argument(
        "mine",
        metavar="MINE",
        help="npy, json or text, in this program's convention or as json says",
    )
    diagnose.add_argument("theirs", metavar="THEIRS", help="npy, json or text, in any convention")
    view_options(diagnose, optional=True)
    resolution_option(diagnose, "texels along each side", action="store")
    diagnose.set_defaults(run=diagnose_command)


def diagnose_command(options: Namespace) -> int:
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
