"""What signatures of `_core` are made of, for type checkers alone."""

from typing import Any, Literal, Protocol, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

NoteKind: TypeAlias = Literal[
    "nothing_seen",
    "nothing_lit",
    "no_warp",
    "no_logarithm",
    "warp_distance_raised",
    "warp_weakened",
    "slide_raised",
    "light_in_box",
    "stable",
    "cover_unused",
    "no_lit_sample",
    "covers_samples",
    "border_outside",
    "face_unseen",
    "check_matrix",
]

class CameraChanges(TypedDict, total=False):
    eye: npt.ArrayLike
    target: npt.ArrayLike
    forward: npt.ArrayLike
    up: npt.ArrayLike
    fov_y: float
    aspect: float
    near: float
    far: float

# What the extension takes and makes of the package's own: `shadowlab.Convention`, `shadowlab.aliasing.Footprint`.
class ConventionLike(Protocol):
    def from_ours(self, matrix: Any) -> npt.NDArray[Any]: ...
    def to_ours(self, matrix: Any) -> npt.NDArray[Any]: ...

class FootprintLike(Protocol):
    @property
    def major(self) -> npt.NDArray[Any]: ...
    @property
    def minor(self) -> npt.NDArray[Any]: ...
    @property
    def perspective(self) -> npt.NDArray[Any]: ...
    @property
    def perspective_ts(self) -> npt.NDArray[Any]: ...
    @property
    def projection(self) -> npt.NDArray[Any]: ...
    @property
    def jacobian(self) -> npt.NDArray[Any]: ...
    @property
    def map(self) -> npt.NDArray[np.int16]: ...
    @property
    def depth(self) -> npt.NDArray[Any]: ...
    @property
    def resolution(self) -> tuple[int, int]: ...
    @property
    def size(self) -> tuple[int, int]: ...
    @property
    def maps(self) -> int: ...
    @property
    def measured(self) -> npt.NDArray[np.bool_]: ...
    def summary(self, *, bands: Any = 6) -> Any: ...
    def counts(self) -> dict[str, int]: ...
