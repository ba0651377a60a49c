"""A technique of which only the name and the settings are known: its class stayed where the study was saved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NoReturn

from ..errors import UnsupportedError
from ..travel import Value

if TYPE_CHECKING:
    from ..types import Setting


@dataclass(frozen=True, eq=False)
class AbsentTechnique(Value):
    """What tables say of a technique that is not there.

    Attributes
    ----------
    name : str
    settings : mapping
    """

    name: str
    settings: Mapping[str, Setting]

    def parameterize(self, *_: Any, **__: Any) -> NoReturn:
        """Raises: nothing is known of how it makes maps.

        Raises
        ------
        UnsupportedError
        """
        raise UnsupportedError(
            f"technique {self.name!r}: it came from outside of this package, and a saved study has its name alone; "
            "evaluate with the technique itself"
        )
