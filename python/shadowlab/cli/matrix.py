"""Shadow matrices on the command line: `matrix` writes them, `diagnose` names what sets two apart."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from ..errors import ArgumentError
from ..text import parse_resolutions, parse_size
from .view import load_view


def matrix_command(options: argparse.Namespace) -> int:
    """Prints a technique's shadow_clip_from_world: column vectors, NDC x, y in [-1, 1], z in [0, 1], 0 at the light."""
    from ..conventions.convention import Convention
    from ..conventions.files import details, written
    from ..techniques.registry import technique_of

    resolution = one_resolution(options.resolution or ["1024"])
    specs = options.technique or ["lispsm"]
    if len(specs) != 1:
        raise ArgumentError(f"technique: expected one, got {' and '.join(specs)}; ask for one matrix at a time")
    if options.out == "":
        raise ArgumentError("out: expected the name of a file, got nothing; leave --out away for standard output")
    convention = Convention.of(options.convention)
    technique = technique_of(specs[0])
    scene, camera, light, _ = load_view(options, None if options.size is None else parse_size(options.size))
    # Somebody else's matrices are what they are, whatever the view.
    fitting = getattr(technique, "parameterize", None)
    p = technique if fitting is None else fitting(scene, camera, light, resolution=resolution)
    content = written(p, options.format, convention)
    if options.format != "json":
        for line in details(p, convention):
            print(f"shadowlab: note: {line}", file=sys.stderr)
    write_out(content, options.out)
    return 0


def diagnose_command(options: argparse.Namespace) -> int:
    """Says what sets two shadow matrices apart. Exit status 0 where both are one map, however written, else 1."""
    from ..conventions.diagnosis import diagnose
    from ..conventions.files import matrix_technique, read

    resolution = one_resolution([options.resolution])
    mine = matrix_technique(f"matrix:file={options.mine}", {"file": options.mine})
    scene = camera = None
    if options.scene is not None:
        scene, camera, _, _ = load_view(options, None if options.size is None else parse_size(options.size))
    theirs = read(Path(options.theirs))["matrix"]
    found = diagnose(mine, theirs, camera=camera, scene=scene, resolution=resolution)
    left = f"{found.texels:.6g} texels, {found.depth:.6g} of depth"
    print(f"{found}\nconvention: {found.convention}\nlargest difference: {left}")
    return 0 if found.same else 1


def one_resolution(texts: list[str]) -> int:
    """The only number of texels of what was given."""
    resolutions = [r for text in texts for r in parse_resolutions(text)]
    if len(resolutions) != 1:
        raise ArgumentError(f"resolution: expected one number of texels, got {','.join(texts)!r}; give one")
    return resolutions[0]


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
