"""Cameras of `_core`, which exports them, and what they see."""

from typing import final

import numpy as np
import numpy.typing as npt
from typing_extensions import Unpack

from ._core_scene import Scene
from ._core_types import CameraChanges, ConventionLike, Float, Size

@final
class Camera:
    """A camera (right-handed, looking along -z of its view space, NDC z in [0, 1]): a perspective one, by `look_at`, whose rays run
    from `eye`, or an orthographic one, by `orthographic`, whose rays run along `forward`.
    """

    @staticmethod
    def look_at(
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        *,
        up: npt.ArrayLike | None = None,
        fov_y: float = ...,
        aspect: float = ...,
        near: float = 0.1,
        far: float = 1000.0,
        shift: npt.ArrayLike | None = None,
    ) -> Camera:
        """A perspective camera at `eye` that looks at `target`.

        Parameters
        ----------
        eye, target : (3,) array_like
            Positions, world units.
        up : (3,) array_like, optional
            Any vector not parallel to the view. +y where none is given; for a view along the y axis then what +y becomes as a
            camera tilts that way: -z of one that looks straight down, +z of one that looks straight up.
        fov_y : float
            Full vertical field of view, radians, in (0, pi).
        aspect : float
            Width by height.
        near, far : float
            Depths along the view direction, 0 < near < far, world units. `far` may be infinite: depth buffers then hold
            `1 - near / z`, and maps are made for all that there is in the scene.
        shift : (2,) array_like
            How far the middle of the picture lies to the right of the view axis and above it, in half widths and half heights
            of the picture (an off-centre frustum, a shifted lens): (0, 1) has straight ahead at the lower edge. At most 1e6.

        Raises
        ------
        ArgumentError
            For anything not finite or outside its range, and for a given `up` parallel to the view.

        Warns
        -----
        ShadowlabWarning
            Where no `up` is given and +y will not do.
        """
    @staticmethod
    def orthographic(
        eye: npt.ArrayLike,
        target: npt.ArrayLike,
        up: npt.ArrayLike | None = None,
        *,
        height: float,
        aspect: float = ...,
        near: float = 0.1,
        far: float = 1000.0,
        shift: npt.ArrayLike | None = None,
    ) -> Camera:
        """An orthographic camera that looks from `eye` towards `target`: all of its rays run that way.

        Parameters
        ----------
        eye, target : (3,) array_like
            Positions, world units. Depths begin at `eye`, which is in the middle of the picture.
        up : (3,) array_like, optional
            As for `look_at`.
        height : float
            Full height of the view volume, world units, above 0.
        aspect : float
            Width by height.
        near, far : float
            Depths along the view direction, near < far, world units, both finite. A view volume that begins behind `eye` has a
            negative `near`.
        shift : (2,) array_like
            As for `look_at`.

        Raises
        ------
        ArgumentError
            For anything not finite or outside its range, and for a given `up` parallel to the view.

        Warns
        -----
        ShadowlabWarning
            Where no `up` is given and +y will not do.

        Examples
        --------
        >>> import shadowlab as sl
        >>> plan = sl.Camera.orthographic((0, 20, 0), (0, 0, 0), (0, 0, -1), height=30, near=0, far=40)
        >>> plan.is_orthographic, plan.height, plan.fov_y
        (True, 30.0, 0.0)
        """

    @staticmethod
    def from_matrices(
        view: npt.ArrayLike,
        projection: npt.ArrayLike,
        convention: ConventionLike | str | None = None,
        *,
        far: float | None = None,
    ) -> Camera:
        """The camera of a view and a projection matrix, such as an engine has.

        Parameters
        ----------
        view : (4, 4) array_like
            View from world: a rotation and a translation. Either handedness of view space will do.
        projection : (4, 4) array_like
            Clip from view: perspective, of a shifted lens or not, with a far plane or without, or orthographic.
        convention : Convention or str, optional
            How both are written, as for `Parameterization.from_matrix`: "opengl", "direct3d", "vulkan", "reversed_z",
            "webgpu:vectors=row"... Its axes are those of the world that `view` starts from. As ours where none is given.
        far : float, optional
            Far plane, world units, for a projection that has none, whose far plane is at infinity otherwise.

        Returns
        -------
        Camera
            Exact up to the rounding of what the matrices hold; `far` up to that times far / near, since it cancels there.

        Raises
        ------
        ArgumentError
            For numbers that are not finite; a view that scales, shears or is no rotation; a sheared or singular projection, or one
            with an oblique near plane; a `far` for a projection that has a far plane; matrices that mirror the world, or have
            depths in another order than the convention.
        UnknownNameError
            For a convention that does not exist.

        Examples
        --------
        >>> import shadowlab as sl
        >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
        >>> back = sl.Camera.from_matrices(camera.view, camera.projection)
        >>> round(back.far, 9)
        100.0
        """

    def replace(self, **changes: Unpack[CameraChanges]) -> Camera:
        """The same camera with other settings; what is not named stays as it is, bit for bit.

        Parameters
        ----------
        eye : (3,) array_like
            Moves the camera; it looks the same way unless `target` or `forward` is given.
        target : (3,) array_like
            Turns it to this point.
        forward : (3,) array_like
            Turns it along this vector, of any length above 0; instead of `target`.
        up : (3,) array_like
            Any vector not parallel to the view; the camera's own `up` where it is turned and none is given, or what that becomes
            as the camera tilts where it is turned along it.
        fov_y, height : float
            As for `look_at` and `orthographic`: a perspective camera has a field of view, an orthographic one a height.
        aspect, near, far : float
            As for `look_at`.
        shift : (2,) array_like
            As for `look_at`.

        Returns
        -------
        Camera

        Raises
        ------
        UnknownNameError
            For another name; the message lists the valid ones.
        ArgumentError
            As for `look_at`, for both `target` and `forward`, and for `fov_y` or `height` of the other kind of camera.

        Warns
        -----
        ShadowlabWarning
            Where the camera is turned along its own `up`, and none is given.

        Examples
        --------
        >>> import shadowlab as sl
        >>> camera = sl.Camera.look_at((0, 2, 9), (0, 0, 0), near=1, far=100)
        >>> camera.replace(near=2.0).near, camera.replace(far=100.0) == camera
        (2.0, True)
        """

    @property
    def eye(self) -> Float:
        """(3,) float64: position, world units. Rays of an orthographic camera do not run through it: depths begin there."""
    @property
    def right(self) -> Float:
        """(3,) float64, unit: the picture's right."""
    @property
    def up(self) -> Float:
        """(3,) float64, unit: the picture's up, across the view."""
    @property
    def forward(self) -> Float:
        """(3,) float64, unit: the way the camera looks."""
    @property
    def is_orthographic(self) -> bool:
        """Whether all rays of the camera are parallel."""
    @property
    def fov_y(self) -> float:
        """Full vertical field of view, radians; 0 of an orthographic camera, whose rays are parallel. A shift does not change it."""
    @property
    def height(self) -> float:
        """Full height of the view volume, world units: of an orthographic camera at every depth, of a perspective one at depth 1,
        2 tan(fov_y / 2).
        """
    @property
    def shift(self) -> tuple[float, float]:
        """How far the middle of the picture lies to the right of the view axis and above it, in half widths and half heights."""
    @property
    def aspect(self) -> float:
        """Width by height."""
    @property
    def near(self) -> float:
        """Depth of the near plane along the view direction, world units."""
    @property
    def far(self) -> float:
        """Depth of the far plane along the view direction, world units; infinity of a perspective camera without an end."""
    @property
    def view(self) -> Float:
        """(4, 4) float64: view from world."""
    @property
    def projection(self) -> Float:
        """(4, 4) float64: clip from view."""
    @property
    def clip_from_world(self) -> Float:
        """(4, 4) float64: clip from world."""
    def depth(self, points: npt.ArrayLike) -> Float:
        """Depth along the view direction of world points: (N, 3) -> (N,)."""
    def corners(self, depth: float) -> Float:
        """The corners of the picture at a depth, world.

        Parameters
        ----------
        depth : float
            Along the view direction, world units; finite.

        Returns
        -------
        (4, 3) ndarray of float64
            Left and right at the bottom, then left and right at the top.

        Raises
        ------
        ArgumentError
            For a depth that is not a finite number.
        """

    def rays(self, pixels: npt.ArrayLike, size: Size) -> tuple[Float, Float]:
        """The rays of places in the picture.

        Parameters
        ----------
        pixels : (N, 2) array_like
            x to the right and y down, pixels from the picture's upper left corner: the first pixel's centre is (0.5, 0.5).
        size : (int, int)
            Width and height of the picture, pixels.

        Returns
        -------
        origins, directions : (N, 3) ndarray of float64
            World units. `origins + z * directions` has camera depth z: directions are not normalised.

        Raises
        ------
        ArgumentError
            For arrays of another shape, numbers that are not finite, or a side that is not above 0.

        Examples
        --------
        >>> import shadowlab as sl
        >>> camera = sl.Camera.orthographic((0, 0, 9), (0, 0, 0), height=2, aspect=1)
        >>> origins, directions = camera.rays([(0, 0), (2, 2)], (2, 2))
        >>> origins.tolist(), directions.tolist()
        ([[-1.0, 1.0, 9.0], [1.0, -1.0, 9.0]], [[0.0, 0.0, -1.0], [0.0, 0.0, -1.0]])
        """

    def bounded(self, scene: Scene) -> Camera:
        """The same camera with a finite far plane: its own, or in place of an infinite one a plane just behind all of a scene.

        Parameters
        ----------
        scene : Scene
            What it sees.

        Returns
        -------
        Camera

        Examples
        --------
        >>> import numpy as np
        >>> import shadowlab as sl
        >>> scene = sl.library.robots()
        >>> camera = scene.camera.replace(far=np.inf)
        >>> bool(np.isfinite(camera.bounded(scene.scene).far)), scene.camera.bounded(scene.scene) == scene.camera
        (True, True)
        """

    def _repr_html_(self) -> str:
        """The values as a table, for notebooks."""
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...

@final
class GBuffer:
    """What a camera sees, one record a pixel."""
    @property
    def size(self) -> tuple[int, int]:
        """(width, height) in pixels."""
    @property
    def depth(self) -> npt.NDArray[np.float32]:
        """(H, W) float32: NDC depth in [0, 1], 1 where nothing is."""
    @property
    def view_depth(self) -> npt.NDArray[np.float32]:
        """(H, W) float32: distances along the view, world units; infinite where nothing is.

        Raises
        ------
        StateError
            For a G-buffer that version 0.1 pickled before it stored its camera.
        """
    @property
    def position(self) -> Float:
        """(H, W, 3) float64: world positions; the origin where nothing is. Computed at the first look."""
    @property
    def position_relative(self) -> npt.NDArray[np.float32]:
        """(H, W, 3) float32: world positions minus `origin`."""
    @property
    def origin(self) -> Float:
        """(3,) float64: the world point positions are stored relative to."""
    @property
    def normal(self) -> npt.NDArray[np.float32]:
        """(H, W, 3) float32: unit geometric normals on the side of the eye; zero where nothing is."""
    @property
    def triangle(self) -> npt.NDArray[np.int32]:
        """(H, W) int32: row of the face array the mesh was made from; -1 where nothing is."""
    @property
    def instance(self) -> npt.NDArray[np.int32]:
        """(H, W) int32: index of the instance; -1 where nothing is."""
    def crop(self, x: int, y: int, width: int, height: int) -> GBuffer:
        """A rectangle of the picture: the same records, bit for bit, relative to the same origin.

        Parameters
        ----------
        x, y : int
            Column and row of its upper left pixel.
        width, height : int
            Pixels.

        Returns
        -------
        GBuffer

        Raises
        ------
        ArgumentError
            For a rectangle without pixels, or one that leaves the picture.

        Examples
        --------
        >>> import shadowlab as sl
        >>> scene = sl.library.scene("robots")
        >>> g = sl.Renderer("cpu").gbuffer(scene, scene.camera, size=(16, 9))
        >>> part = g.crop(3, 4, 5, 2)
        >>> part.size, bool((part.depth == g.depth[4:6, 3:8]).all())
        ((5, 2), True)
        """
    def __eq__(self, other: object, /) -> bool: ...
    def __hash__(self) -> int: ...
