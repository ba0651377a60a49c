"""Keys of runs: the same for the same run in every process, another for everything that changes a number."""

from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError
from shadowlab.experiments.store import keys
from shadowlab.experiments.store.keys import ALGORITHMS, key_of_parts, run_key

HOW = {
    "resolution": 64, "metrics": ("misclassified", "texels"), "bias": None, "filter": "nearest", "blend": 0.0,
    "stored": None, "backend": "cpu",
}  # fmt: skip
OTHER_HOW = [
    {"resolution": 65}, {"metrics": ("misclassified",)}, {"metrics": ()}, {"bias": sl.Bias(world=0.01)},
    {"filter": "bilinear"}, {"filter": "pcf:size=3"}, {"blend": 0.1}, {"stored": "back"}, {"backend": "gpu (one)"},
    {"backend": "gpu (two)"}, {"phases": 2}, {"timing": True},
    {"metrics": ("misclassified", "texels", "mine#1")}, {"metrics": ("misclassified", "texels", "mine#2")},
]  # fmt: skip
CODE = """
import shadowlab as sl
from shadowlab.experiments.store.keys import run_key
from test_store_keys import HOW, made_view
print(run_key(made_view(), sl.technique("z_partition:count=2,inner=lispsm"), **HOW))
"""


def made_view(**changes):
    scene = sl.library.scene("robots")
    view = sl.View(scene, scene.camera, scene.light, size=(32, 18))
    return replace(view, **changes)


def key(item="lispsm", view=None, **changes):
    return run_key(view or made_view(), item, **HOW | changes)


def test_a_key_is_the_same_in_another_process():
    words = [sys.executable, "-c", CODE]
    done = subprocess.run(words, cwd=__file__.rpartition("/")[0], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == key("z_partition:count=2,inner=lispsm")


def test_names_and_ways_of_saying_it_do_not_count():
    same = [
        key(), key(sl.technique("lispsm")), key(sl.technique("lispsm", near="optimal")), key(bias=sl.Bias()),
        key(view=made_view(label="another name")), key(metrics=["texels", "misclassified"]), key(stored="front"),
        key(resolution=np.int64(64)), key(stored=sl.Stored()), key(blend=0),
    ]  # fmt: skip
    assert len(set(same)) == 1
    assert len(same[0]) == 32


def test_everything_that_changes_a_number_counts():
    view = made_view()
    scene, camera, light = view.scene, view.camera, view.light
    views = [
        made_view(size=(32, 19)), made_view(scene=sl.library.scene("forest", trees=3)),
        made_view(camera=camera.replace(near=camera.near * 1.001)), made_view(light=(light,)),
        made_view(light=sl.DirectionalLight((0.3, -1, 0.1))), made_view(light=(light, light)),
    ]  # fmt: skip
    matrices = [
        sl.technique("uniform").parameterize(scene, camera, light, resolution=resolution) for resolution in (64, 65)
    ]
    items = [
        "uniform",
        "lispsm:near=basic",
        "lispsm:near_factor=1.5",
        "lispsm:filter=bilinear",
        "tsm",
        "preset:filament",
    ]
    found = [key(), *(key(view=one) for one in views), *(key(item=one) for one in (*items, *matrices))]
    found += [key(**change) for change in OTHER_HOW]
    assert len(set(found)) == len(found)
    assert key(matrices[0]) == key(sl.technique("uniform").parameterize(scene, camera, light, resolution=64))


def test_a_version_of_the_algorithms_has_keys_of_its_own(monkeypatch):
    before = key()
    monkeypatch.setattr(keys, "ALGORITHMS", ALGORITHMS + 1)
    assert key() != before


def test_techniques_from_elsewhere_count_by_their_class():
    class Mine:
        name, settings = "uniform", sl.technique("uniform").settings
        parameterize = None

    assert key(Mine()) != key("uniform")
    assert key(Mine()) == key(Mine())
    Mine.settings = {"what": object()}
    with pytest.raises(ArgumentError, match="plain values"):
        key(Mine())
    Mine.settings = {"what": SimpleNamespace()}
    with pytest.raises(ArgumentError, match="plain values"):
        key(Mine())
    deep = []
    for _ in range(40):
        deep = [deep]
    Mine.settings = {"what": deep}
    with pytest.raises(ArgumentError, match="deep"):
        key(Mine())


def test_types_and_borders_of_parts_count():
    parts = [
        (1,),
        (1.0,),
        (True,),
        ("1",),
        (b"1",),
        (None,),
        ("a", "bc"),
        ("ab", "c"),
        (("a", "b"), "c"),
        ("a", ("b", "c")),
    ]
    parts += [(np.array([1.0]),), (np.array([1]),), (np.array([[1.0]]),), ({"a": 1},), ((("a", 1),),), (0.0,), (-0.0,)]
    found = [key_of_parts(*one) for one in parts]
    assert len(set(found)) == len(found) - 1, "a mapping and its sorted pairs are one"
    assert key_of_parts({"a": 1, "b": 2}) == key_of_parts({"b": 2, "a": 1})
    shared = "x" * 2000
    assert key_of_parts(shared, shared) == key_of_parts("x" * 2000, "y".replace("y", "x") * 2000)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"resolution": 0}, ArgumentError), ({"metrics": [1]}, ArgumentError), ({"bias": 1}, ArgumentError),
        ({"filter": "what"}, UnknownNameError), ({"blend": 2}, ArgumentError), ({"stored": 1}, ArgumentError),
        ({"backend": None}, ArgumentError), ({"item": 1}, ArgumentError), ({"phases": 0}, ArgumentError),
        ({"item": "what"}, UnknownNameError),
    ],
)  # fmt: skip
def test_what_is_no_run_has_no_key(change, error):
    with pytest.raises(error):
        key(**change)
