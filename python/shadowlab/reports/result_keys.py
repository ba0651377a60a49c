"""The keys of results.json and advice.json: what each holds. docs/results.md is generated from here.

A key of a list's items stands after `[]`. `*` stands for names that techniques choose.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

_VECTOR = "3 numbers"
_CAMERA: Mapping[str, str] = {
    "eye": f"{_VECTOR}: position in the world", "right": f"{_VECTOR}: unit vector", "up": f"{_VECTOR}: unit vector",
    "forward": f"{_VECTOR}: unit vector along the view", "fov_y": "number: angle of the view, radians",
    "aspect": "number: width by height", "near": "number: depth of the near plane, world units",
    "far": 'number: of the far plane, or "inf"', "height": "number: of an orthographic camera's picture, world units",
    "shift": "2 numbers: of the picture, in parts of it, where it is shifted",
}  # fmt: skip
_LIGHT: Mapping[str, str] = {
    "kind": "text: directional, spot or point", "position": f"{_VECTOR}: of a spot or a point light",
    "direction": f"{_VECTOR}: the way that a directional light or the middle of a spot travels",
    "cone_angle": "number: full angle of a spot, radians",
    "range": "number: how far a spot or a point light reaches, world units",
}  # fmt: skip
_HEAD: Mapping[str, str] = {
    "format": "integer: of this page; raised when a key goes or means something else",
    "created": "text: the time in UTC", "versions.*": "text: of shadowlab, Python and the packages that numbers pass",
    "platform": "text: the system", "renderer.backend": "text: cpu or gpu", "renderer.adapter": "text: which one",
    "scene.source": "text: file, name in the library, or size", "scene.python": "text: the line that makes it",
    "scene.triangles": "integer", "scene.instances": "integer",
    "scene.bounds[]": f"{_VECTOR}: lower corner, upper corner",
    "bias.*": "number: each part of the bias by its unit (docs/bias.md)", "filter": "text: how maps were read",
    "blend": "number: share of a map's range over which the next is mixed in", "stored": "text: what maps stored",
    "verdict": "text: what the tables say",
}  # fmt: skip
_TAIL: Mapping[str, str] = {
    "state": "object: the result exactly, for `load` alone; not described here, and not stable",
    "digest": "text: of all above, in hexadecimal; `load` refuses a file that was changed",
}

#: results.json of a study.
STUDY_KEYS: Mapping[str, str] = MappingProxyType({
    **_HEAD,
    **{f"camera.{name}": text for name, text in _CAMERA.items()},
    **{f"light.{name}": text for name, text in _LIGHT.items()},
    "size": "2 integers: width and height of the picture, pixels",
    "truth_ms": "number or null: milliseconds of tracing the truth; null of a study without it",
    "runs[].label": "text: as the table calls the technique",
    "runs[].technique": "text: name of the technique", "runs[].settings.*": "value: every setting of the technique",
    "runs[].COLUMN": "value: the columns of a run (docs/columns.md); null where nothing was measured",
    "runs[].notes": "texts: what the technique could not do as asked",
    "runs[].matrices[]": "4 times 4 numbers: shadow clip from world, row by row, of each map",
    "runs[].values.*": "number: what the technique reports of itself",
    "runs[].selection": "text: how pixels choose a map",
    "runs[].partitions[].technique": "text: what made this map",
    "runs[].partitions[].eye_depth": '2 numbers: camera depths that it serves, world units; the last may be "inf"',
    "runs[].partitions[].post_warp.kind": "text: none, log or rectilinear",
    "runs[].partitions[].post_warp.scale": "number: of a logarithm", "runs[].partitions[].post_warp.offset": "number",
    "runs[].partitions[].post_warp.x": "pairs of numbers: knots of a rectilinear warp, NDC before and after",
    "runs[].partitions[].post_warp.y": "pairs of numbers: the same for y",
    "runs[].partitions[].values.*": "number: of this map",
    "runs[].texels.*": "value: sizes of texels in the picture, as `aliasing.Summary.to_dict()` has them",
    "runs[].causes.*": "value: wrong pixels by cause, how far edges are displaced, and both by depth",
    "reproduce.python": "text: the script that computes all again",
    "reproduce.command": "text or null: the command line; null where it cannot say all",
    "pictures": "texts: names of the PNG files beside it",
    **_TAIL,
})  # fmt: skip

#: advice.json of an advice.
ADVICE_KEYS: Mapping[str, str] = MappingProxyType({
    **_HEAD,
    "measure.*": "text: what is ranked by: name, title, unit, direction, meaning, and the Python that gives it",
    "over": "text: mean or worst of the views", "memory": "integers: budgets, bytes",
    "views[].label": "text: of camera and light", "views[].camera_label": "text", "views[].light_label": "text",
    "views[].light_angle": "number or null: radians", "views[].light_elevation": "number or null: radians",
    "views[].size": "2 integers: pixels", "views[].counted": "flag: whether anything could be measured in it",
    "views[].filled": "number: share of its pixels that show a surface",
    **{f"views[].camera.{name}": text for name, text in _CAMERA.items()},
    **{f"views[].light.{name}": text for name, text in _LIGHT.items()},
    "candidates[].label": "text: as tables call it", "candidates[].technique": "text: what makes it again",
    "candidates[].name": "text: of its technique", "candidates[].settings.*": "value: every setting",
    "candidates[].matrices[]": "4 times 4 numbers: of one that is matrices",
    "table[].COLUMN": "value: the columns of `advise` (docs/columns.md); null where nothing was measured",
    "table[].reproduce": "text or null: the script that computes the row again",
    "runs[].COLUMN": "value: the columns of `advise.runs`", "runs[].reproduce": "text or null: as above",
    "switches[].COLUMN": "value: the columns of `advise.switches`",
    "phases": "integer: shifts of the texels over which wrong pixels were counted",
    "gains[].memory": "integer: bytes", "gains[].best": "text: the best warp or split", "gains[].baseline": "text",
    "gains[].relation": "text: better, about_equal or worse than the baseline",
    "gains[].drawn": "texts: what was drawn",
    "unjudged": "number: largest share of a view's visible pixels that no run could compare",
    "untried[].*": "value: technique, cause, and what goes with the cause (`sl.Advice`)",
    "reproduce": "text: the script that computes all again",
    **_TAIL,
})  # fmt: skip
