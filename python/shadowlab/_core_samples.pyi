"""Samples of `_core`, which exports them."""

from typing import Literal, TypeAlias, final

import numpy as np
import numpy.typing as npt

from ._core_camera import Camera, GBuffer
from ._core_scene import Light
from ._core_types import Float, MapsLike, Matrices

_Size: TypeAlias = "int | tuple[int, int]"
_States: TypeAlias = "npt.NDArray[np.int8] | npt.NDArray[np.float32]"

@final
class Samples:
    """What a camera sees, as points: what techniques make maps for."""
    @staticmethod
    def from_gbuffer(
        gbuffer: GBuffer,
        camera: Camera,
        light: Light | None = None,
        *,
        shadows: _States | None = None,
        count: int = 4096,
    ) -> Samples:
        """The pixels of a picture as samples.

        Parameters
        ----------
        gbuffer : GBuffer
            What the camera sees.
        camera : Camera
            The camera that sees it.
        light : DirectionalLight, SpotLight or PointLight, optional
            The light of `shadows`.
        shadows : (H, W) int8 or float32, optional
            States as `trace.Truth` has them, or a shadow mask (1 lit, 0 in shadow). Without them only `range=seen` and
            `fit=seen` can use the samples.
        count : int
            Samples at the shadows' edges that are kept, evenly chosen.

        Raises
        ------
        ArgumentError
            An argument of another type or shape; shadows without a light.
        """
    @staticmethod
    def from_arrays(
        positions: npt.ArrayLike,
        normals: npt.ArrayLike,
        camera: Camera,
        light: Light | None = None,
        *,
        size: _Size | None = None,
        shadows: npt.ArrayLike | None = None,
        edge_normals: npt.ArrayLike | None = None,
        weights: npt.ArrayLike | None = None,
        count: int = 4096,
    ) -> Samples:
        """Samples of an engine's own.

        Parameters
        ----------
        positions : (N, 3) float
            Visible surface points, world units; kept as float32 relative to their mean.
        normals : (N, 3) float
            Unit normals on the side of the eye.
        camera : Camera
            The camera that sees them.
        light : DirectionalLight, SpotLight or PointLight, optional
            The light of `shadows`.
        size : int or (int, int), optional
            Width and height, pixels, of the picture that they were taken from: each stands for a pixel of it. 128 where
            none is given.
        shadows : (N,) int8 or float32, optional
            States of the samples, as of `from_gbuffer`.
        edge_normals : (N, 2) float, optional
            Unit normals, x to the right and y down, of the shadows' edges in the picture; zero for a sample at no edge.
        weights : (N,) float, optional
            Pixels at edges that a sample stands for; 1 where none are given.
        count : int
            Samples at the shadows' edges that are kept, evenly chosen.

        Raises
        ------
        ArgumentError
            An argument of another type or shape, or not finite; shadows or edges without a light, edges without shadows.
        """
    def __len__(self) -> int: ...
    @property
    def receivers(self) -> int:
        """Visible surface points that the hulls of maps are made of: all pixels that show something, or all given points."""
    @property
    def light(self) -> Light | None:
        """The light of the shadow states; None without any."""
    @property
    def camera(self) -> Camera | None:
        """The camera that sees them."""
    @property
    def size(self) -> tuple[int, int] | None:
        """(width, height) of the picture that they come from, pixels."""
    @property
    def positions(self) -> Float:
        """(N, 3) float64: world positions."""
    @property
    def normals(self) -> Float:
        """(N, 3) float64: unit normals on the side of the eye."""
    @property
    def eye_depth(self) -> Float:
        """(N,) float64: depths along the view, world units."""
    @property
    def jacobian(self) -> Float:
        """(N, 2, 3) float64: the eye's Jacobian, pixels (x to the right, y down) per world unit (E.5)."""
    @property
    def weights(self) -> npt.NDArray[np.float32]:
        """(N,) float32: pixels that a sample stands for."""
    @property
    def shadow(self) -> npt.NDArray[np.int8]:
        """(N,) int8: states as `trace.Truth` has them; -1 where they are not known."""
    @property
    def edge_normals(self) -> npt.NDArray[np.float32]:
        """(N, 2) float32: unit normals of the shadows' edges in the picture, x to the right and y down, from shadow to light; zero
        for a sample at no edge.
        """
    def outside(self, parameterization: MapsLike | Matrices) -> tuple[int, int]:
        """Visible points that face the light and that no map holds, where all is lit.

        Parameters
        ----------
        parameterization : Parameterization
            The maps.

        Returns
        -------
        (int, int)
            All of them, and those in shadow.

        Raises
        ------
        ArgumentError
            Samples without shadow states.
        """
    def missed(self, parameterization: MapsLike | Matrices, holds: Literal["shadow", "seen"] = "shadow") -> int:
        """Visible points that a map must hold and that no map holds.

        Parameters
        ----------
        parameterization : Parameterization
            The maps.
        holds : {"shadow", "seen"}
            What maps must hold: points in shadow and their neighbours in the picture, as outside of a map all is lit; or all
            that face the light. As `Technique.holds`.

        Returns
        -------
        int

        Raises
        ------
        ArgumentError
            Samples without shadow states, or another word.
        """
    def edge_width(self, parameterization: MapsLike | Matrices, *, resolution: _Size | None = None) -> float:
        """The mean width of the texels of maps across the edges of visible shadows, pixels (10.8).

        A width w counts as 32 (1 - exp(-w / 32)), so that no single edge can rule the mean; an edge that no map holds counts as
        32.

        Parameters
        ----------
        parameterization : Parameterization
            The maps.
        resolution : int or (int, int), optional
            Texels along the sides of each map; those it was made for where none are given.

        Returns
        -------
        float
            Pixels of the picture that the samples come from; 0 where they have no edge.

        Raises
        ------
        ArgumentError
            Samples without shadow states, or a resolution that is none.
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
