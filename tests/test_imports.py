"""Importing the package, loading a file and the command line load no library that they do not need."""

from __future__ import annotations

import subprocess
import sys

import pytest
import trimesh

from shadowlab.scene.formats.readers import BESIDE_MESHES, kinds
from shadowlab.scene.formats.through_trimesh import trimesh_formats

# Libraries that take longer to import than a small scene to draw, and that none of what is tested here needs.
HEAVY = (
    "trimesh", "matplotlib", "scipy", "pandas.plotting._matplotlib", "PIL", "IPython", "networkx", "numpy.ma", "email",
)  # fmt: skip
BALL = trimesh.creation.icosphere(2)
OWN_FORMATS = ("obj", "ply", "stl", "off", "glb", "dae", "3mf")
SMALL = ("--size", "96x54", "--resolution", "64", "--backend", "cpu")


def loaded_after(code: str, *arguments: str, among: tuple[str, ...] = HEAVY) -> list[str]:
    """The libraries that a new interpreter has loaded after some code."""
    tail = f"\nprint('LOADED', *[name for name in {among!r} if name in sys.modules])"
    words = [sys.executable, "-c", f"import sys\n{code}{tail}", *arguments]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    return done.stdout.splitlines()[-1].split()[1:]


@pytest.fixture(scope="module")
def meshes(tmp_path_factory):
    """A file of each format that is read here, by ending."""
    folder = tmp_path_factory.mktemp("meshes")
    found = {}
    for ending in OWN_FORMATS:
        path = folder / f"ball.{ending}"
        trimesh.Scene(BALL).export(path) if ending in ("glb", "3mf") else BALL.export(path)
        found[ending] = str(path)
    return found


def test_importing_the_package_loads_nothing_heavy():
    assert loaded_after("import shadowlab", among=(*HEAVY, "pandas", "tqdm")) == []


def test_what_is_loaded_is_seen():
    assert loaded_after("import trimesh", among=("trimesh", "matplotlib")) == ["trimesh"]


@pytest.mark.parametrize("ending", OWN_FORMATS)
def test_formats_that_are_read_here_need_no_trimesh(meshes, ending):
    code = "import shadowlab as sl; assert sl.load_scene(sys.argv[1]).triangle_count == int(sys.argv[2])"
    assert loaded_after(code, meshes[ending], str(len(BALL.faces)), among=(*HEAVY, "pandas")) == []


def test_faces_with_texture_and_normals_need_no_trimesh(tmp_path):
    text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvn 0 0 1\n"
    (tmp_path / "a.obj").write_text(text + "f 1/1/1 2/2/1 3/1/1\nf 2/1/1 4/2/1 3/2/1\n")
    code = "import shadowlab as sl; assert sl.load_scene(sys.argv[1]).triangle_count == 2"
    assert loaded_after(code, str(tmp_path / "a.obj")) == []


def test_an_archive_of_a_mesh_with_its_textures_needs_no_trimesh(tmp_path, meshes):
    import zipfile

    with zipfile.ZipFile(tmp_path / "ball.zip", "w") as archive:
        archive.write(meshes["obj"], "ball.obj")
        for name in ("ball.mtl", "wood.png", "readme.txt"):
            archive.writestr(name, b"nothing")
    code = "import shadowlab as sl; assert sl.load_scene(sys.argv[1]).triangle_count == int(sys.argv[2])"
    assert loaded_after(code, str(tmp_path / "ball.zip"), str(len(BALL.faces))) == []


def test_what_lies_beside_meshes_is_no_mesh_to_trimesh():
    assert not BESIDE_MESHES & trimesh_formats()


@pytest.mark.parametrize("scene", ["@robots", *OWN_FORMATS])
def test_a_comparison_with_its_report_loads_nothing_heavy(meshes, scene, tmp_path):
    code = "from shadowlab.cli.main import main\nassert main(sys.argv[1:]) == 0"
    words = ("compare", meshes.get(scene, scene), *SMALL, "--out", str(tmp_path / "report"))
    # Pillow draws the camera frustum over the maps.
    among = (*(name for name in HEAVY if name != "PIL"), "pandas")
    assert loaded_after(code, *words, among=among) == []
    assert (tmp_path / "report" / "report.html").exists()


def test_another_format_is_read_by_trimesh(tmp_path):
    path = tmp_path / "ball.xyz"
    path.write_text("0 0 0\n1 0 0\n")
    code = "import shadowlab as sl\ntry: sl.load_scene(sys.argv[1])\nexcept sl.errors.ShadowlabError: pass"
    assert "trimesh" in loaded_after(code, str(path))
    assert "xyz" in kinds()


@pytest.mark.parametrize(
    "words",
    [("techniques",), ("demo", "--backend", "cpu"), ("explain", "@robots", "--pixel", "9,9", "--no-trials", *SMALL)],
)
def test_other_commands_load_nothing_heavy(words, tmp_path):
    code = "import os\nos.chdir(sys.argv[1])\nfrom shadowlab.cli.main import main\nassert main(sys.argv[2:]) in (0, 1)"
    assert loaded_after(code, str(tmp_path), *words, among=(*(name for name in HEAVY if name != "PIL"), "pandas")) == []
