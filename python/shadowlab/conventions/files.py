"""Shadow matrices in files: npy, JSON with all there is to know beside them, plain text.

A technique's text may name such a file, `matrix:file=mine.npy,convention=opengl`, and is then somebody else's matrix.
"""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Literal, get_args

import numpy as np

from .. import _core
from ..errors import ArgumentError, LoadError, UnknownNameError
from ..text import plain
from ..types import PostWarp
from .convention import Convention

#: How matrices are written into a file.
Form = Literal["npy", "json", "text"]
FORMS: tuple[Form, ...] = get_args(Form)

# Bytes of a file of matrices: more than any that means something.
LARGEST_FILE = 1 << 26
# What may stand beside the file in the text of such a technique, as `Parameterization.from_matrix` takes it.
FIELDS = ("file", "convention", "resolution", "eye_depth", "selection")


def written(p: _core.Parameterization, form: Form, convention: Convention) -> bytes:
    """The matrices of a parameterization in a convention as the bytes of a file: "npy", "json" or "text"."""
    found = np.asarray(p.to(convention))
    if form == "npy":
        stream = io.BytesIO()
        np.save(stream, found)
        return stream.getvalue()
    stack = found.reshape(-1, 4, 4)
    if form == "json":
        data = record_of(p, convention, stack)
        return (json.dumps(plain(data), indent=1, allow_nan=False, ensure_ascii=False) + "\n").encode()
    blocks = ["\n".join(" ".join(f"{x:24.17g}" for x in row) for row in m) for m in stack]
    return ("\n\n".join(blocks) + "\n").encode()


def record_of(p: _core.Parameterization, convention: Convention, stack: np.ndarray) -> dict[str, Any]:
    """The matrices and what one needs beside them."""
    parts = p.partitions
    return {
        "technique": p.technique,
        "settings": dict(p.settings),
        "convention": str(convention),
        "resolution": p.resolution,
        "border_texels": p.border_texels,
        "selection": p.selection,
        "matrix": stack[0] if len(stack) == 1 else None,
        "matrices": stack,
        "eye_depth": [list(part.eye_depth) for part in parts],
        "post_warp": [{"kind": part.post_warp, **part.post_warp_terms, **knots_of(part)} for part in parts],
        "regions": [part.region for part in parts],
        "values": dict(p.values),
        "values_of_maps": [dict(part.values) for part in parts],
        "notes": [str(note) for note in p.notes],
    }


def details(p: _core.Parameterization, convention: Convention) -> list[str]:
    """What one needs beside numbers alone, a line each; nothing for one matrix of ours without a word to say."""
    lines = [str(note) for note in p.notes]
    if convention != Convention():
        lines.append(f"written for {convention}")
    lost = []
    for i, part in enumerate(p.partitions, 1):
        near, far = part.eye_depth
        terms = ", ".join(f"{name} {value!r}" for name, value in part.post_warp_terms.items())
        after = f"; y is replaced by the logarithm of w with {terms}" if terms else ""
        if part.post_warp_knots is not None:
            x, y = map(len, part.post_warp_knots)
            after = f"; x and y are replaced by ascending functions of themselves with {x} and {y} knots"
        if after or len(p.partitions) > 1:
            lines.append(f"map {i}: {part.technique}, camera depths {near:g} to {far:g}{after}")
        lost += ["logarithms"] if terms else []
        lost += ["rectilinear warps"] if part.post_warp == "rectilinear" else []
        lost += ["the rays that each map serves"] if len(part.region) else []
    if len(p.partitions) > 1:
        lost += ["camera depths", f"selection by {p.selection}"]
    if lost:
        lines.append(f"not kept in this format: {', '.join(dict.fromkeys(lost))}; --format json keeps them")
    return lines


def matrix_technique(text: str, values: Mapping[str, object]) -> _core.Parameterization:
    """The parameterization of `matrix:file=F,convention=C`.

    Raises
    ------
    UnknownNameError
        For a field that does not exist.
    ArgumentError
        Without a file, and for what `Parameterization.from_matrix` refuses.
    LoadError
        For a file that cannot be read or holds no matrices.
    """
    for name in values:
        if name not in FIELDS:
            raise UnknownNameError(f"technique {text!r}: unknown field {name!r}; expected some of {', '.join(FIELDS)}")
    if "file" not in values:
        raise ArgumentError(
            f"technique {text!r}: expected matrix:file=NAME, got no file; name an npy, json or text file"
        )
    found = read(Path(str(values["file"])))
    found.update({name: value for name, value in values.items() if name != "file"})
    return _core.Parameterization.from_matrix(found.pop("matrix"), **found)


def read(path: Path) -> dict[str, Any]:
    """The matrices of a file under "matrix", and what it says beside them, as `from_matrix` takes it."""
    try:
        with path.open("rb") as file:
            content = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise LoadError(f"file: cannot read {str(path)!r} ({error.strerror or error}); check the path") from error
    if len(content) > LARGEST_FILE:
        raise LoadError(f"file: expected at most {LARGEST_FILE:,} bytes, got more in {str(path)!r}; check the path")
    try:
        if content.startswith(b"\x93NUMPY"):
            return {"matrix": np.load(io.BytesIO(content), allow_pickle=False)}
        text = content.decode()
        if text.lstrip()[:1] in ("{", "["):
            return of_json(json.loads(text))
        rows = [line.split("#")[0].replace(",", " ").split() for line in text.splitlines()]
        return {"matrix": of_rows([[float(word) for word in row] for row in rows if row])}
    except (ValueError, TypeError, KeyError, AttributeError) as error:
        raise LoadError(
            f"file: {str(path)!r} holds no matrices ({' '.join(str(error).split())}); "
            "give four rows of four numbers for each, or an npy or json file of them"
        ) from error


def of_rows(rows: list[list[float]]) -> np.ndarray:
    """One matrix of four rows, or several."""
    if not rows or len(rows) % 4 or any(len(row) != 4 for row in rows):
        raise ValueError(f"{len(rows)} rows of {sorted({len(row) for row in rows})} numbers")
    stack = np.array(rows).reshape(-1, 4, 4)
    return stack[0] if len(stack) == 1 else stack


def of_json(data: Any) -> dict[str, Any]:
    """The matrices of a list, or of what `written` makes."""
    if isinstance(data, list):
        return {"matrix": np.array(data, dtype=np.float64)}
    matrices = data["matrices"] if data.get("matrices") is not None else data["matrix"]
    found: dict[str, Any] = {"matrix": np.array(matrices, dtype=np.float64)}
    found.update({name: data[name] for name in ("convention", "resolution", "selection") if name in data})
    if "eye_depth" in data:
        found["eye_depth"] = [[float(depth) for depth in pair] for pair in data["eye_depth"]]
    warps = [warp_of(post) for post in data.get("post_warp") or ()]
    if any(warp is not None for warp in warps):
        found["post_warp"] = warps
    if any(data.get("regions") or ()):
        found["regions"] = [np.array(rows, dtype=np.float64).reshape(-1, 4) for rows in data["regions"]]
    return found


def warp_of(post: Mapping[str, Any]) -> PostWarp | None:
    """What follows a matrix, as `from_matrix` takes it."""
    if post["kind"] == "none":
        return None
    if post["kind"] == "log":
        return "log", float(post["scale"]), float(post["offset"])
    if post["kind"] == "rectilinear":
        return "rectilinear", np.array(post["x"], dtype=np.float64), np.array(post["y"], dtype=np.float64)
    raise ValueError(f"unknown post_warp {post['kind']!r}")


def knots_of(part: _core.Partition) -> dict[str, np.ndarray]:
    """The knots of a rectilinear map by axis; empty for another."""
    return dict(zip("xy", part.post_warp_knots or (), strict=False))
