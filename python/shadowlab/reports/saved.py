"""Results as files, and back: results.json of a study and advice.json of an advice.

Both are for any program (docs/results.md has every key), and hold the result exactly beside that, as `state`. A digest
over all of it finds files that were changed or damaged, so that no number is read that was not written.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from ..errors import LoadError, StateError
from ..experiments.advice import Advice
from ..experiments.study import Study
from ..text import plain, reason_of
from .saved_state import result_of_state, state_of_result

if TYPE_CHECKING:
    from .. import _core

T = TypeVar("T", Study, Advice)

#: Of both files; raised when a key goes or means something else. New keys do not raise it.
FORMAT_OF_RESULTS = 1
STUDY_FILE, ADVICE_FILE = "results.json", "advice.json"
DIGEST_BYTES_OF_FILE = 16


def file_text(data: Mapping[str, Any], result: Study | Advice) -> str:
    """The text of the file: the data for everybody, the exact result, and the digest of both."""
    document = {"format": FORMAT_OF_RESULTS, **plain(dict(data)), "state": state_of_result(result)}
    if isinstance(result, Study):
        document["state"] |= {"sentences": result.sentences, "truth_ms": result.truth_ms}
    document["digest"] = digest_of_document(document)
    return json.dumps(document, indent=1, allow_nan=False, ensure_ascii=False) + "\n"


def load_result(kind: type[T], path: Path, scene: _core.Scene | None) -> T:
    """The result in a file, or in the directory that `save` wrote.

    Raises
    ------
    LoadError
        Where there is no such file, and for one that is no saved result of this kind.
    StateError
        For one that was changed since, or that a newer version wrote.
    ArgumentError
        For a scene that is not the one of the result.
    """
    name = STUDY_FILE if kind is Study else ADVICE_FILE
    file = path / name if path.is_dir() else path
    what = f"expected {name} of a saved {kind.__name__}"
    fix = f"give the directory that {kind.__name__}.save wrote"
    try:
        document = json.loads(file.read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError) as error:
        raise LoadError(f"path {str(file)!r}: {what}, cannot read it ({reason_of(error)}); {fix}") from None
    if not (isinstance(document, dict) and isinstance(document.get("state"), dict) and "format" in document):
        raise LoadError(f"path {str(file)!r}: {what}, got another file, or one that an older version wrote; {fix}")
    if document["format"] != FORMAT_OF_RESULTS:
        raise StateError(
            f"path {str(file)!r}: {what} in format {FORMAT_OF_RESULTS}, got {document['format']!r}; update shadowlab"
        )
    digest = document.pop("digest", None)
    if digest != digest_of_document(document):
        raise StateError(f"path {str(file)!r}: {what} as it was written, but it has changed; copy it again")
    state = document["state"]
    try:
        made, origins = result_of_state(state)
    except StateError as error:
        raise StateError(f"path {str(file)!r}: {error}") from None
    if not isinstance(made, kind):
        raise LoadError(f"path {str(file)!r}: {what}, got that of {type(made).__name__}; {fix}")
    for origin in origins if scene is not None else ():
        origin.take(scene)
    if isinstance(made, Study):
        # Made from the pictures, which are not there yet.
        made.__dict__.update(_sentences=tuple(state["sentences"]), truth_ms=state["truth_ms"])
    return made


def digest_of_document(document: Mapping[str, Any]) -> str:
    """The digest of a file's content, whatever its blanks and the order of its keys."""
    text = json.dumps(document, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=DIGEST_BYTES_OF_FILE).hexdigest()
