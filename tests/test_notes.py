"""Notes are data with a text."""

from __future__ import annotations

import ast
import copy
import pickle
from pathlib import Path

import pytest

import shadowlab as sl

PACKAGE = Path(sl.__file__).parent


def one_of_each():
    """A note of every kind, with all details that the kind has."""
    for kind, details in sl.Note.KINDS.items():
        with pytest.raises(sl.errors.ArgumentError, match="values: expected") as told:
            sl.Note(kind, details, {"nothing": 1.0})
        names = str(told.value).partition("expected ")[2].partition(", got")[0]
        named = {} if names == "no numbers" else dict.fromkeys(names.removeprefix("a dict of ").split(", "), 0.5)
        yield sl.Note(kind, details, named)


NOTES = list(one_of_each())
NO_WARP = sl.Note("no_warp", ["light_along_axis"])


@pytest.mark.parametrize("note", NOTES, ids=lambda note: note.kind)
def test_a_note_is_a_value(note):
    for protocol in range(2, pickle.HIGHEST_PROTOCOL + 1):
        for one in (note, note.about([0, 2])):
            back = pickle.loads(pickle.dumps(one, protocol))
            assert back == one
            assert (hash(back), str(back), repr(back)) == (hash(one), str(one), repr(one))
    assert copy.deepcopy(note) == note == copy.copy(note)
    assert note != note.about([0])
    assert note != str(note)
    assert eval(repr(note.about([3, 1, 1])), {"Note": sl.Note}) == note.about((1, 3))
    assert note.about([3, 1, 1]).maps == (1, 3)
    assert note.maps is None
    assert len(note.reasons) == len(note.details)
    assert all(reason in str(note) for reason in note.reasons)


def test_a_number_of_several_maps_is_a_range():
    one = sl.Note("warp_distance_raised", values={"given": 0.0, "least": 0.5})
    several = sl.Note("warp_distance_raised", values={"given": (0.0, 0.0), "least": (0.25, 0.5)}, maps=[1])
    assert one.values == {"given": 0.0, "least": 0.5}
    assert several.values == {"given": 0.0, "least": (0.25, 0.5)}
    assert str(several) == "map 2: warp distance 0e0 raised to 2.5e-1 to 5e-1, the least for the body"


def test_the_stub_lists_the_kinds():
    stub = ast.parse((PACKAGE / "_core_types.pyi").read_text(encoding="utf-8"))
    (listed,) = [
        node.value.slice.elts
        for node in stub.body
        if isinstance(node, ast.AnnAssign) and getattr(node.target, "id", "") == "NoteKind"
    ]
    assert [item.value for item in listed] == list(sl.Note.KINDS)


WRONG = {
    "a kind": (("no_such_kind",), "UnknownNameError"),
    "a detail": (("no_warp", ["left"]), "UnknownNameError"),
    "details as text": (("no_warp", "flat_body"), "ArgumentError"),
    "a number too few": (("warp_distance_raised", (), {"given": 1.0}), "ArgumentError"),
    "a number too many": (("stable", (), {"given": 1.0}), "ArgumentError"),
    "text for a number": (("light_in_box", (), {"distance": "far"}), "ArgumentError"),
    "a range that falls": (("light_in_box", (), {"distance": (2.0, 1.0)}), "ArgumentError"),
    "no dict": (("light_in_box", (), 3), "ArgumentError"),
    "no maps": (("stable", (), None, ()), "ArgumentError"),
    "a negative map": (("stable", (), None, [-1]), "ArgumentError"),
}


@pytest.mark.parametrize(("given", "error"), WRONG.values(), ids=WRONG)
def test_what_is_no_note_is_refused(given, error):
    with pytest.raises(getattr(sl.errors, error)):
        sl.Note(*given)


def test_notes_of_maps_are_gathered_with_the_maps_and_ranges():
    scene = sl.library.scene("robots")
    along = sl.DirectionalLight(scene.camera.forward)
    split = sl.technique("z_partition:count=3,inner=lispsm/lispsm/uniform").by_body()
    p = split.parameterize(scene, scene.camera, along)
    assert p.notes == (NO_WARP.about([0, 1]),)
    assert [part.notes for part in p.partitions] == [(NO_WARP,), (NO_WARP,), ()]
    assert "; ".join(map(str, p.notes)) == "maps 1, 2: no warp, a uniform map: the light runs along the view"
    assert repr(p).endswith(f"; {p.notes[0]})")
    weak = sl.technique("z_partition:count=3,inner=(xpsm:min_sin=1)").by_body()
    weak = weak.parameterize(scene, scene.camera, scene.light)
    (note,) = weak.notes
    sines = [part.notes[0].values["sine"] for part in weak.partitions]
    assert note.details == ("below_min_sin",)
    assert note.maps is None
    assert note.values["sine"] == ((min(sines), max(sines)) if len(set(sines)) > 1 else sines[0])
    assert sl.Parameterization.from_matrix(p.matrices).notes == ()


def test_notes_of_several_lights_count_the_maps_of_all():
    scene = sl.library.scene("robots")
    lights = [scene.light, sl.DirectionalLight(scene.camera.forward)]
    view = sl.View(scene, scene.camera, lights, size=(16, 9))
    by_body = sl.technique("z_partition:count=2,inner=lispsm").by_body()
    run = sl.evaluate(view, by_body, 64, metrics=[], renderer="cpu")
    assert run.row()["maps"] == 4
    assert run.notes == (NO_WARP.about([2, 3]),)
    assert run.row()["notes"] == str(run.notes[0])
    both = sl.View(scene, scene.camera, lights[1:] * 2, size=(16, 9))
    assert sl.evaluate(both, "lispsm", 64, metrics=[], renderer="cpu").notes == (NO_WARP,)


def test_a_doubt_is_a_note_of_the_run_and_keeps_it_out_of_rankings():
    scene = sl.library.scene("robots")
    p = sl.technique("uniform").parameterize(scene, scene.camera, scene.light, resolution=64)
    wrong = sl.Parameterization.from_matrix(p.matrix.T, resolution=64)
    run = sl.evaluate(sl.View(scene, scene.camera, scene.light, size=(32, 18)), wrong, 64, metrics=[], renderer="cpu")
    assert run.notes == (run.doubt,)
    assert run.doubt.kind == "check_matrix"
    advice = sl.advise(
        scene, scene.camera, scene.light, techniques={"uniform": "uniform", "engine": wrong}, memory="16 KiB",
        size=(32, 18), renderer="cpu", progress=False,
    )  # fmt: skip
    engine = next(one for one in advice.standings if one.candidate == "engine")
    assert engine.doubted
    assert engine.rank is None
    assert engine.notes == (run.doubt,)
    assert f"engine is left out of the ranking: {'; '.join(run.doubt.reasons)}." in advice.verdict
    assert advice.table.set_index("technique")["notes"]["engine"] == str(run.doubt)
