"""Values in other processes: spawn, forkserver, pools, joblib and Dask; hashes that are the same in all of them."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import travel_support as support
from conftest import imported
from travel_support import bits, examples, fitted, there_and_back

import shadowlab as sl
from shadowlab import _core

# Of the scenes below, as version 1 of the hash has them: any change is a new version of it.
RECORDED = {
    "triangle": "cd229924ffbdbba06291eee6493cb933c53be67ce70985fa0933cbf106614487",
    "small_scene": "bf708a5dc712e9cd5e5c073beb8c2484aa03c1df30de995313372e508fc70aea",
}
SCRIPT = """
import pickle, sys
sys.path.insert(0, sys.argv[1])
import travel_support
for scene in travel_support.recorded_scenes().values():
    print(scene.content_hash)
"""
# Other things than objects of this process: callables and drawings of renderers have no bits of their own.
NAMES = [name for name in support.EXAMPLES if name not in ("Advice", "Preset", "Run", "Study")]


@pytest.fixture(scope="module")
def values():
    """One of each."""
    return [examples(name)[-1] for name in NAMES]


def check(values, answer) -> None:
    """Asserts that values came back, and that the other process read the same bits."""
    back, hashes, read = answer
    assert hashes == [value.content_hash for value in values if isinstance(value, _core.Scene)]
    for value, found, theirs in zip(values, back, read, strict=True):
        assert found == value
        assert bits(found) == bits(value) == theirs


# Not every system has a fork server. What forks copies memory instead of pickling.
@pytest.mark.parametrize("method", sorted({"spawn", "forkserver"} & {*multiprocessing.get_all_start_methods()}))
def test_another_process(method, values):
    with multiprocessing.get_context(method).Pool(1) as pool:
        check(values, pool.apply(there_and_back, (values,)))


def test_a_pool_of_executors(values):
    context = multiprocessing.get_context("spawn")
    scene, camera, light = support.view()
    techniques = [sl.technique(name) for name in ("uniform", "lispsm", "tsm")]
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=context) as pool:
        check(values, pool.submit(there_and_back, values).result())
        found = pool.map(fitted, techniques, [scene] * 3, [camera] * 3, [light] * 3)
        assert list(found) == [fitted(technique, scene, camera, light) for technique in techniques]


def test_errors_come_back_from_another_process():
    scene, camera, _ = support.view()
    with multiprocessing.get_context("spawn").Pool(1) as pool, pytest.raises(sl.errors.UnsupportedError, match="point"):
        pool.apply(fitted, (sl.technique("tsm"), scene, camera, sl.PointLight((0, 5, 0), range=50)))


def test_joblib(values):
    joblib = imported("joblib")
    answer = joblib.Parallel(n_jobs=2)(joblib.delayed(there_and_back)([value]) for value in values)
    for value, one in zip(values, answer, strict=True):
        check([value], one)
    # What a cache goes by.
    scene = sl.library.scene("robots")
    assert joblib.hash(scene) == joblib.hash(sl.library.scene("robots"))
    assert joblib.hash(scene) != joblib.hash(scene.with_ground())


def test_dask(values):
    distributed = imported("distributed")
    scene, camera, light = support.view()
    with (
        distributed.LocalCluster(
            n_workers=1, threads_per_worker=1, processes=True, dashboard_address=None, memory_limit=0
        ) as cluster,
        distributed.Client(cluster) as client,
    ):
        check(values, client.submit(there_and_back, values).result(timeout=120))
        technique = sl.technique("lispsm", near="optimal")
        found = client.submit(fitted, technique, client.scatter(scene), camera, light).result(timeout=120)
        assert found == fitted(technique, scene, camera, light)


def test_content_hashes_are_those_on_record():
    found = {name: scene.content_hash for name, scene in support.recorded_scenes().items()}
    assert found == RECORDED


@pytest.mark.parametrize("seed", ["0", "12345"])
def test_content_hashes_of_another_process(seed):
    tests = str(Path(__file__).parent)
    environment = {**os.environ, "PYTHONHASHSEED": seed}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, tests], env=environment, capture_output=True, text=True, check=True, timeout=120
    )
    assert done.stdout.split() == list(RECORDED.values())


def test_a_content_hash_changes_with_the_content_alone():
    scene = support.small_scene()
    same = support.small_scene()
    same.source, same.recipe, same.cameras = "elsewhere", "", {}
    assert same.content_hash == scene.content_hash
    assert len(scene.content_hash) == 64
    assert int(scene.content_hash, 16) > 0
    meshes, index, placed = scene.meshes, scene.mesh_index, scene.transforms
    moved = placed.copy()
    moved[2, 0, 3] = np.nextafter(moved[2, 0, 3], 1)
    others = [
        sl.Scene(meshes[::-1], 1 - index, placed),
        sl.Scene(meshes, index, moved),
        sl.Scene(meshes, index[[0, 2, 1]], placed[[0, 2, 1]]),
        sl.Scene(meshes, index[:2], placed[:2]),
        sl.Scene([*meshes, meshes[0]], index, placed),
    ]
    assert len({one.content_hash for one in [scene, *others]}) == 1 + len(others)
    baked = sl.Scene.from_arrays(*scene.to_arrays())
    assert baked != scene
    assert scene.meshes[0].content_hash == support.small_scene().meshes[0].content_hash
