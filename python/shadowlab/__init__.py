"""The laboratory for shadow-map parameterizations.

Importing the package touches no graphics driver.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from . import aliasing, errors, trace
from ._core import (
    Bias,
    Camera,
    DirectionalLight,
    GBuffer,
    Note,
    Parameterization,
    Partition,
    PointLight,
    Renderer,
    Samples,
    SpotLight,
    Stored,
    Technique,
    __version__,
    set_threads,
    threads,
)
from .aliasing.blur import blur
from .aliasing.filters import filters
from .conventions.convention import Convention
from .scene import library
from .scene.alpha_test import AlphaTest
from .scene.axes import turned
from .scene.files import load_scene
from .scene.formats.limits import Limits
from .scene.scenes import Scene
from .scene.source import Source
from .scene.view import View
from .techniques.presets import Preset, preset, presets
from .techniques.registry import technique, techniques
from .techniques.temporal_fit import TemporalFit

if TYPE_CHECKING:
    from . import plot
    from .conventions.diagnosis import Diagnosis, diagnose
    from .doctor import report
    from .experiments.advice import Advice
    from .experiments.advise import advise
    from .experiments.compare import compare
    from .experiments.evaluate import evaluate
    from .experiments.explain_pixel import explain_pixel
    from .experiments.pixel_explanation import PixelExplanation
    from .experiments.predict import Prediction, predict
    from .experiments.prefiltered import PrefilteredMaps, prefiltered_maps
    from .experiments.run import Run
    from .experiments.scene_optimal import scene_optimal_experiment
    from .experiments.smallest_bias import SmallestBias, smallest_bias
    from .experiments.store.read_store import read_store
    from .experiments.store.store import Store
    from .experiments.study import Study
    from .experiments.sweeps.drawn_rows import random
    from .experiments.sweeps.named_axes import to_xarray
    from .experiments.sweeps.sweep import sweep
    from .scene.default_view import default_view, default_views

__all__ = [
    "Advice",
    "AlphaTest",
    "Bias",
    "Camera",
    "Convention",
    "Diagnosis",
    "DirectionalLight",
    "GBuffer",
    "Limits",
    "Note",
    "Parameterization",
    "Partition",
    "PixelExplanation",
    "PointLight",
    "Prediction",
    "PrefilteredMaps",
    "Preset",
    "Renderer",
    "Run",
    "Samples",
    "Scene",
    "SmallestBias",
    "Source",
    "SpotLight",
    "Store",
    "Stored",
    "Study",
    "Technique",
    "TemporalFit",
    "View",
    "__version__",
    "advise",
    "aliasing",
    "blur",
    "compare",
    "default_view",
    "default_views",
    "diagnose",
    "errors",
    "evaluate",
    "explain_pixel",
    "filters",
    "library",
    "load_scene",
    "plot",
    "predict",
    "prefiltered_maps",
    "preset",
    "presets",
    "random",
    "read_store",
    "report",
    "scene_optimal_experiment",
    "set_threads",
    "smallest_bias",
    "sweep",
    "technique",
    "techniques",
    "threads",
    "to_xarray",
    "trace",
    "turned",
]

# `from shadowlab.library import ...`, as if the module stood at the top.
sys.modules[f"{__name__}.library"] = library

#: Loaded at the first use: they need pandas and matplotlib, which take longer to import than most renders.
_LAZY = {
    "Advice": "experiments.advice",
    "Diagnosis": "conventions.diagnosis",
    "PixelExplanation": "experiments.pixel_explanation",
    "Prediction": "experiments.predict",
    "PrefilteredMaps": "experiments.prefiltered",
    "Run": "experiments.run",
    "SmallestBias": "experiments.smallest_bias",
    "Store": "experiments.store.store",
    "Study": "experiments.study",
    "advise": "experiments.advise",
    "compare": "experiments.compare",
    "default_view": "scene.default_view",
    "default_views": "scene.default_view",
    "diagnose": "conventions.diagnosis",
    "evaluate": "experiments.evaluate",
    "explain_pixel": "experiments.explain_pixel",
    "predict": "experiments.predict",
    "prefiltered_maps": "experiments.prefiltered",
    "plot": "plot",
    "random": "experiments.sweeps.drawn_rows",
    "read_store": "experiments.store.read_store",
    "report": "doctor",
    "scene_optimal_experiment": "experiments.scene_optimal",
    "smallest_bias": "experiments.smallest_bias",
    "sweep": "experiments.sweeps.sweep",
    "to_xarray": "experiments.sweeps.named_axes",
}


if not TYPE_CHECKING:  # a checker that saw this would take every misspelt name

    def __getattr__(name: str) -> object:
        if name not in _LAZY:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
        from importlib import import_module

        module = import_module(f".{_LAZY[name]}", __name__)
        value = module if name == _LAZY[name] else getattr(module, name)
        globals()[name] = value
        return value


def __dir__() -> list[str]:
    return sorted(__all__)
