"""The command `shadowlab matrix`: the shadow matrices of a technique, in anybody's convention."""

from __future__ import annotations

import sys
from pathlib import Path

import click

from ..conventions.files import FORMS
from ..errors import ArgumentError
from .command import Command, Option, Options
from .options import (
    light_option,
    one_resolution,
    resolution_option,
    scene_argument,
    size_given,
    technique_option,
    view_options,
)
from .view import load_view


def matrix_command(options: Options) -> int:
    """Prints a technique's shadow_clip_from_world: column vectors, NDC x, y in [-1, 1], z in [0, 1], 0 at the light."""
    from .._core import Renderer
    from ..conventions.convention import Convention
    from ..conventions.files import details, written
    from ..experiments.evaluate import fitted
    from ..scene.view import View
    from ..techniques.kinds import is_parameterization
    from ..techniques.registry import technique_of

    resolution = one_resolution(options)
    specs = options.technique or ["lispsm"]
    if len(specs) != 1:
        raise ArgumentError(f"technique: expected one, got {' and '.join(specs)}; ask for one matrix at a time")
    if options.out == "":
        raise ArgumentError("out: expected the name of a file, got nothing; leave --out away for standard output")
    convention = Convention.of(options.convention)
    technique = technique_of(specs[0])
    size = size_given(options)
    scene, camera, light, _ = load_view(options, size)
    # Those of `compare` with the same options; somebody else's matrices are what they are, whatever the view.
    p = (
        technique
        if is_parameterization(technique)
        else fitted(technique, View(scene, camera, light, size), resolution, Renderer("cpu"))
    )
    write_out(written(p, options.format, convention), options.out)
    if options.format != "json":
        for line in details(p, convention):
            print(f"shadowlab: note: {line}", file=sys.stderr)
    return 0


def write_out(content: bytes, path: str | None) -> None:
    """The bytes to a file or to standard output."""
    if path is None:
        sys.stdout.flush()
        sys.stdout.buffer.write(content)
        sys.stdout.buffer.flush()
        return
    try:
        Path(path).write_bytes(content)
    except OSError as error:
        raise ArgumentError(f"out: cannot write {path!r} ({error.strerror or error}); choose another file") from error


MATRIX = Command(
    "matrix",
    matrix_command,
    [
        scene_argument(),
        technique_option("(default: lispsm)"),
        resolution_option("texels along each side the fit is made for"),
        Option(
            "--convention",
            default="webgpu",
            metavar="NAME[:field=value,...]",
            help="how the matrix is written: opengl, direct3d, vulkan... (default: webgpu, column vectors and z in "
            "0..1)",
        ),
        Option("--format", default="text", type=click.Choice(FORMS), help="(default: text)"),
        Option("--out", metavar="FILE", type=click.Path(), help="write there instead of standard output"),
        light_option(),
        *view_options(),
    ],
)
