"""Limits for files that nobody vouches for: a small file may ask for any amount of memory."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import ClassVar

from ...errors import ArgumentError, LoadError
from ...text import shown
from ...travel import Value


@dataclass(frozen=True, eq=False)
class Limits(Value):
    """What `load_scene` reads at most; a file beyond it is refused before memory is asked for.

    Parameters
    ----------
    size : int
        Bytes of a file, of each file it refers to, and of all files of an archive together when unpacked.
    elements : int
        Elements of one array of a file (vertices, indices, instances), and triangles of one polygon list.
    corners : int
        Corners of one polygon.
    instances : int
        Placed meshes of a scene.
    objects : int
        Objects and lists in the text of a glTF file; elements of XML, beside vertices and triangles of 3MF.
    entries : int
        Files in an archive, and material libraries of an OBJ file.
    ratio : float
        Unpacked bytes for each packed byte of an archive, and bytes in memory for each byte of a glTF file.

    Raises
    ------
    ArgumentError
        For a limit that is not a number above 0.

    Examples
    --------
    >>> import shadowlab as sl
    >>> sl.Limits(size=10_000_000).size
    10000000
    """

    size: int = 8 << 30
    elements: int = 1_000_000_000
    corners: int = 1_000_000
    instances: int = 1_000_000
    objects: int = 3_000_000
    entries: int = 10_000
    ratio: float = 1000.0

    STATE_VERSION: ClassVar[int] = 2

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            kinds = (int, float) if field.name == "ratio" else (int,)
            if isinstance(value, bool) or not isinstance(value, kinds) or not value > 0:
                what = "number" if field.name == "ratio" else "whole number"
                raise ArgumentError(f"{field.name}: expected a {what} above 0, got {shown(value)}; give a limit")


def check_limit(limits: Limits, name: str, limit: str, asked: float, what: str) -> None:
    """Nothing, where what a file asks for is within a limit.

    Parameters
    ----------
    limits : Limits
    name : str
        The file.
    limit : str
        The field of `Limits`.
    asked : float
        The amount.
    what : str
        What the amount counts, for the error.

    Raises
    ------
    LoadError
        Beyond it.
    """
    most = getattr(limits, limit)
    if not asked <= most:
        raise LoadError(
            f"{name}: expected at most {most:,} {what}, got {asked:,}; for a file that is meant so, "
            f"load_scene(..., limits=sl.Limits({limit}=...)) takes more"
        )
