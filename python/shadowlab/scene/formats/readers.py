"""Which reader reads which kind of file, archives of files among them."""

from __future__ import annotations

import posixpath
from collections.abc import Callable
from dataclasses import replace

from ...errors import LoadError, SceneError, ShadowlabError
from ..foreign import collected
from ..gathered import Gathered
from ..gltf.reader import read_gltf
from .archives import ARCHIVES, PACKED, Archive, unpacked
from .collada import read_collada
from .given import Given
from .obj import read_obj
from .off import read_off
from .ply import read_ply
from .sources import ending_of, inner_ending
from .stl import read_stl
from .threemf import read_3mf
from .through_trimesh import trimesh_formats, trimesh_scene

#: Readers by kind. Other kinds go through trimesh.
READERS: dict[str, Callable[[Given], Gathered]] = {
    "obj": read_obj,
    "ply": read_ply,
    "off": read_off,
    "stl": read_stl,
    "stl_ascii": read_stl,
    "dae": read_collada,
    "3mf": read_3mf,
    "glb": read_gltf,
    "gltf": read_gltf,
}

#: Endings of what lies beside meshes in archives (materials, textures, buffers, texts); trimesh reads no mesh from it.
BESIDE_MESHES = frozenset({
    "bin", "bmp", "csv", "dds", "exr", "gif", "hdr", "html", "jpeg", "jpg", "ktx2", "md", "mtl", "pdf", "png", "tga",
    "tif", "tiff", "txt", "webp",
})  # fmt: skip


def kinds() -> list[str]:
    """The endings that can be loaded."""
    return sorted({*READERS, *ARCHIVES, *PACKED, *trimesh_formats()})


def gathered_file(given: Given) -> Gathered:
    """The meshes of a file of any kind that can be loaded.

    Raises
    ------
    LoadError
        For a kind that cannot be loaded, and for a broken file.
    """
    if given.kind in ARCHIVES:
        return _of_archive(given)
    if given.kind in PACKED:
        name, kind = inner_ending(given.name, given.kind)
        if not kind:
            raise LoadError(
                f"{given.name}: expected one mesh file in it, with its ending before .{given.kind}, got {name!r}; "
                "archives in archives are not read"
            )
        data = unpacked(given, given.kind)
        return _of_kind(replace(given, name=name, kind=kind, read=lambda: data))
    return _of_kind(given)


def _of_kind(given: Given) -> Gathered:
    reader = READERS.get(given.kind)
    if reader is None:
        if given.kind not in trimesh_formats():
            raise LoadError(
                f"{given.name}: expected a file of a kind that can be loaded ({', '.join(kinds())}), "
                f"got {given.kind or 'no ending'!r}"
            )
        reader = _through_trimesh
    if not given.data:
        raise LoadError(f"{given.name}: expected a mesh file, got an empty one; check the file")
    try:
        return reader(given)
    except LoadError:
        raise
    except ShadowlabError as e:
        raise SceneError(f"{given.name}: {e}") from e
    except (MemoryError, OverflowError) as e:
        raise LoadError(f"{given.name}: expected a mesh that fits into memory, got a larger one; load a part") from e
    except Exception as e:
        # A defect of a reader; whoever loads a file gets the same kind of error for it all the same.
        raise LoadError(f"{given.name}: expected a readable mesh, could not read it ({type(e).__name__}: {e})") from e


def _through_trimesh(given: Given) -> Gathered:
    return collected(trimesh_scene(given))


def _of_archive(given: Given) -> Gathered:
    """All meshes of an archive; files that cannot be read are left out while there are others."""
    archive = Archive.of(given, ARCHIVES[given.kind])
    names = [name for name in archive.names if not _is_of_macos(name)]
    models = [name for name in names if _is_mesh(ending_of(name))]
    packed = [name for name in names if ending_of(name) in (*ARCHIVES, *PACKED)]
    if not models:
        what = f"{packed[0]!r}, an archive in an archive" if packed else f"{len(archive.names):,} other files"
        raise LoadError(f"{given.name}: expected a mesh file in it, got {what}; pack mesh files")
    joined = Gathered(left_out=[f"{name!r}, an archive in an archive" for name in packed])
    failures: list[LoadError | SceneError] = []
    count = 0
    for name in models:
        try:
            found = _of_kind(_entry_given(given, archive, name))
        except (LoadError, SceneError) as e:
            failures.append(e)
            joined.left_out.append(str(e))
            continue
        count += 1
        joined.join(found, name)
    if not count:
        raise failures[0]
    return joined


def _is_mesh(ending: str) -> bool:
    """Whether files with that ending are read as meshes; trimesh is asked where it is not known here."""
    return ending in READERS or (bool(ending) and ending not in BESIDE_MESHES and ending in trimesh_formats())


def _is_of_macos(name: str) -> bool:
    """Whether an entry is what macOS keeps beside each file of an archive, under the file's name after "._"."""
    return name.startswith("__MACOSX/") or posixpath.basename(name).startswith("._")


def _entry_given(given: Given, archive: Archive, name: str) -> Given:
    folder = posixpath.dirname(name)
    names = set(archive.names)

    def find(reference: str) -> bytes | None:
        other = posixpath.join(folder, reference)
        return archive.read(other) if other in names else None

    return Given(f"{given.name}/{name}", ending_of(name), lambda: archive.read(name), find, given.limits)
