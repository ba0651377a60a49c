"""Fixtures for all Python tests: what is installed, scenes, and contexts of other programs, one of each a process.

A missing adapter, program or folder skips the tests that need it and says so; with SHADOWLAB_REQUIRE_ALL=1 it fails
them (the shared scenes excepted: they are not part of the project).
"""

from __future__ import annotations

import importlib
import os
from pathlib import Path

import pytest

# pyrender reads this when it is first imported; nothing else does.
os.environ.setdefault("PYOPENGL_PLATFORM", "egl")

REQUIRE_ALL = os.environ.get("SHADOWLAB_REQUIRE_ALL", "") not in ("", "0")
SHARED_SCENES = Path(__file__).resolve().parents[1].parent / "shared" / "scenes"


def missing(what: str, error: object) -> None:
    """Skip the test, or fail it where everything is required."""
    text = f"{what} is not available: {error}"
    if REQUIRE_ALL:
        pytest.fail(f"{text} (SHADOWLAB_REQUIRE_ALL is set)", pytrace=False)
    pytest.skip(text)


def imported(name: str):
    """The module, or a skip."""
    try:
        return importlib.import_module(name)
    except ImportError as error:
        missing(name, error)


@pytest.fixture(scope="session")
def shared_scenes() -> Path:
    """The folder of shared scenes; tests on it skip where the project stands alone."""
    if not SHARED_SCENES.is_dir():
        pytest.skip("the shared scenes are not beside this checkout")
    return SHARED_SCENES


@pytest.fixture(scope="session")
def moderngl_peer():
    """OpenGL through moderngl, on EGL."""
    imported("moderngl")
    module = importlib.import_module("peers.moderngl_peer")
    try:
        peer = module.ModernGL()
    except Exception as error:  # noqa: BLE001 - glcontext raises bare Exception where EGL fails
        missing("an OpenGL context on EGL", error)
    yield peer
    peer.release()


@pytest.fixture(scope="session")
def pyrender_peer():
    """pyrender on EGL, with the shim for today's numpy."""
    imported("pyrender")
    module = importlib.import_module("peers.pyrender_peer")
    try:
        peer = module.Pyrender()
    except Exception as error:  # noqa: BLE001 - PyOpenGL raises AttributeError, GLError or EGLError, by platform
        missing("pyrender on EGL", error)
    yield peer
    peer.release()


@pytest.fixture(scope="session")
def embreex_peer():
    """The module that wraps embreex."""
    imported("embreex")
    return importlib.import_module("peers.embreex_peer")


@pytest.fixture(scope="session")
def gpu_renderer():
    """The wgpu renderer on any adapter."""
    sl = imported("shadowlab")
    try:
        return sl.Renderer(backend="gpu")
    except sl.errors.ShadowlabError as error:
        missing("a GPU adapter", error)


@pytest.fixture(scope="session", params=["cpu", "gpu"])
def renderer(request):
    """Both renderers, one after the other."""
    if request.param == "gpu":
        return request.getfixturevalue("gpu_renderer")
    return imported("shadowlab").Renderer(backend="cpu")


@pytest.fixture(scope="session")
def mesh(tmp_path_factory) -> str:
    """The path of a file with a box."""
    path = tmp_path_factory.mktemp("meshes") / "box.ply"
    imported("trimesh").creation.box().export(path)
    return str(path)


@pytest.fixture
def run(capfd):
    """Runs the command line in this process: (status, standard output, standard error)."""
    main = imported("shadowlab.cli").main

    def call(*words):
        status = main([str(word) for word in words])
        out, err = capfd.readouterr()
        return status, out, err

    return call


@pytest.fixture
def run_config(run, tmp_path, monkeypatch):
    """Runs a command on the text of a configuration, in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def call(command, file, text, *words):
        Path(file).write_text(text, encoding="utf-8")
        return run(command, file, *words)

    return call
