"""Techniques whose text says how their maps are read: they go before what an experiment says for all."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import shadowlab as sl
from shadowlab.errors import ArgumentError, UnknownNameError
from shadowlab.techniques.variant import Variant
from shadowlab.text import bias_of, bias_text

LOOSE = sl.Bias(slope=1.5, texels=1.0)


@pytest.fixture(scope="module")
def view() -> sl.View:
    scene = sl.library.scene("robots")
    return sl.View(scene, scene.camera, scene.light, size=(160, 90))


def wrong(view, technique, **more):
    return sl.evaluate(view, technique, 256, metrics=["misclassified"], renderer="cpu", **more).errors.count


@pytest.mark.parametrize("name", ["lispsm", "preset:filament", "z_partition:count=2,inner=(lispsm:near=basic)"])
def test_a_text_says_what_the_experiment_would(view, name):
    colon = "," if ":" in name else ":"
    assert wrong(view, f"{name}{colon}bias=(slope=1.5,texels=1)") == wrong(view, name, bias=LOOSE)
    assert wrong(view, f"{name}{colon}filter=pcf2x2") == wrong(view, name, filter="pcf2x2")
    assert wrong(view, f"{name}{colon}bias=none") == wrong(view, name, bias=sl.Bias.none())
    assert wrong(view, f"{name}{colon}bias=none") > 5 * wrong(view, name)


def test_a_text_says_how_cascades_blend(view):
    """`mix` is what experiments call `blend`, beside the setting of that name of z_partition."""
    name = "z_partition:count=3,overlap=0.4,blend=0.7,inner=uniform"

    def mask(technique, **more):
        return sl.evaluate(view, technique, 64, metrics=["mask"], renderer="cpu", filter="bilinear", **more).mask

    plain, blended = mask(name), mask(name, blend=0.4)
    assert (plain != blended).any()
    np.testing.assert_array_equal(mask(f"{name},mix=0.4"), blended)
    np.testing.assert_array_equal(mask(sl.technique(name, mix=0.4)), blended)
    # It goes before what is said for all, and leaves the technique's own setting alone.
    np.testing.assert_array_equal(mask(f"{name},mix=0", blend=0.4), plain)
    made = sl.technique(f"{name},mix=0.4")
    assert (made.mix, made.settings["mix"], made.settings["blend"]) == (0.4, 0.4, 0.7)
    assert sl.evaluate(view, made, 64, metrics=["mask"], renderer="cpu").blend == 0.4


def test_it_goes_before_what_is_said_for_all(view):
    own = sl.evaluate(view, "lispsm:bias=none", 256, metrics=["mask"], renderer="cpu", bias=LOOSE, filter="pcf2x2")
    assert own.bias == sl.Bias.none()
    assert own.filter == "pcf2x2"
    assert own.row()["spec"] == "lispsm:bias=none"


def test_a_grid_of_texts_is_one_table(view):
    texts = [f"uniform:bias=(slope={slope},texels={texels})" for slope in (0, 1) for texels in (0, 2)]
    study = sl.compare(
        view.scene, view.camera, view.light, texts, resolution=256, size=view.size, renderer="cpu", phases=1,
        progress=False,
    )  # fmt: skip
    assert study.table["technique"].tolist() == texts
    assert (study.table["failure"] == "").all()
    acne = study.table.set_index("technique")["acne"]
    assert acne[texts[0]] > acne[texts[1]] > acne[texts[3]]


@pytest.mark.parametrize(
    "text",
    [
        "lispsm:near=basic,bias=(slope=1.0,texels=0.25)",
        "uniform:bias=none",
        "lispsm:filter=pcf2x2,bias=plane=1.0",
        "z_partition:count=2,mix=0.25,stored=(back:format=f16)",
    ],
)
def test_texts_come_back(text):
    made = sl.technique(text)
    assert isinstance(made, Variant)
    assert sl.technique(made) == made
    assert pickle.loads(pickle.dumps(made)) == copy.deepcopy(made) == made
    again = sl.technique(made.name, **made.settings)
    assert again == made
    assert hash(again) == hash(made)


def test_keywords_take_objects():
    made = sl.technique("lispsm", bias=LOOSE, filter="pcf2x2")
    assert (made.bias, made.filter, made.name) == (LOOSE, "pcf2x2", "lispsm")
    assert sl.technique(sl.technique("lispsm"), bias="slope=1.5,texels=1").bias == LOOSE


@pytest.mark.parametrize("bias", [sl.Bias(), sl.Bias.none(), LOOSE, sl.Bias(slope_limit=float("inf"), ndc=1e-7)])
def test_a_bias_is_what_its_text_says(bias):
    assert bias_of(bias_text(bias)) == bias


def test_words_of_biases():
    assert bias_text(sl.Bias()) == "default"
    assert bias_text(sl.Bias.none()) == "none"
    assert bias_of(" none ") == sl.Bias.none()


@pytest.mark.parametrize(
    ("text", "error", "said"),
    [
        ("lispsm:bias=(slop=1)", UnknownNameError, "slop"),
        ("lispsm:bias=3", ArgumentError, "bias"),
        ("lispsm:bias=(slope=1),bias=none", ArgumentError, "twice"),
        ("lispsm:filter=median", UnknownNameError, "median"),
        ("lispsm:mix=2", ArgumentError, "mix: expected a number from 0 to 1"),
        ("lispsm:mix=some", ArgumentError, "mix: expected a number from 0 to 1"),
        ("lispsm:stored=(back:format=f16,format=f32)", ArgumentError, "format: expected one value"),
        ("preset:filament,near=3", ArgumentError, "no parameters"),
        ("preset:filamint,bias=none", UnknownNameError, "filamint"),
    ],
)
def test_mistakes_are_named(text, error, said):
    with pytest.raises(error, match=said):
        sl.technique(text)


def test_matrices_that_are_given_have_none(view):
    p = sl.technique("uniform").parameterize(view.scene, view.camera, view.light)
    with pytest.raises(ArgumentError, match="say it to the experiment"):
        sl.technique(p, bias="none")


def test_what_a_technique_says_goes_before_the_arguments_and_what_it_does_not_say_is_theirs(view):
    said = {"bias": LOOSE, "filter": "bilinear", "blend": 0.25, "stored": "back"}
    of_text = "z_partition:count=2,overlap=0.2"
    for name, own, found in (
        ("bias", "bias=none", sl.Bias.none()), ("filter", "filter=pcf:size=3", "pcf:size=3"), ("blend", "mix=0.5", 0.5),
        ("stored", "stored=(midpoint:format=f16)", sl.Stored("midpoint:format=f16")),
    ):  # fmt: skip
        run = sl.evaluate(view, f"{of_text},{own}", 32, metrics=[], renderer="cpu", **said)
        wanted = {**said, "stored": sl.Stored("back"), name: found}
        assert {key: getattr(run, key) for key in said} == wanted


@pytest.mark.parametrize("text", ["lispsm:stored=back", "scene_optimal:bias=none,filter=bilinear"])
def test_a_fit_that_makes_matrices_takes_no_way_to_read_them_and_says_which(text):
    with pytest.raises(ArgumentError, match=r"says nothing of how its maps are read, got (stored|bias, filter) in '"):
        sl.TemporalFit(text)
    with pytest.raises(ArgumentError, match="says nothing of how its maps are read"):
        sl.TemporalFit(sl.technique(text))
