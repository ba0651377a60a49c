"""What an advice says of switches: where the winner changes, or that it does not."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..experiments.measures import Measure
from ..experiments.memory import memory_text
from ..experiments.ranking import MEMORY
from ..experiments.views import degrees
from ..text import listed
from .words import MOST_TOLD


def switch_sentences(switched: Sequence[Mapping[str, Any]], measure: Measure, several: bool, budgets: int) -> list[str]:
    """Where the winner changes, or that it does not."""
    alike: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in switched:
        names = ("along", "camera", "from", "to", "winner_from", "winner_to")
        alike.setdefault(tuple(row[name] for name in names), []).append(row)
    # What holds with most budgets first, the rest as in the table.
    order = sorted(alike.values(), key=lambda rows: (rows[0]["along"] != MEMORY, -len(rows)))
    sentences = [_switch(rows, measure, budgets) for rows in order[:MOST_TOLD]]
    if len(order) > MOST_TOLD:
        sentences.append(f"The table of switches has {sum(map(len, order[MOST_TOLD:]))} more.")
    angles = any(row["along"] != MEMORY for row in switched)
    if several and not angles:
        each = "with each budget, one" if budgets > 1 else "one"
        sentences.append(
            f"The answer does not switch between views: {each} candidate is best or about equal all along."
        )
    return sentences


def _switch(rows: Sequence[Mapping[str, Any]], measure: Measure, budgets: int) -> str:
    """One change of winner, with the numbers of the largest budget that has it."""
    row = rows[-1]
    of = f" in {memory_text(row['memory'])}" if len(rows) > 1 else ""

    def beside(own: float | None, other: float | None, rival: str) -> str:
        mine = "–" if own is None else measure.text(own)
        if own is not None and other is not None and other < own:
            # It stays the winner here for what it is in the views next to this one.
            return f"({mine}{of}, {measure.equal_because} of {rival}'s {measure.text(other)})"
        return f"({mine}{of}; {rival} {'has no number' if other is None else measure.text(other)})"

    first = f"{row['winner_from']} {beside(row['error_from'], row['other_from'], row['winner_to'])}"
    second = f"{row['winner_to']} {beside(row['error_to'], row['other_to'], row['winner_from'])}"
    if row["along"] == MEMORY:
        return (
            f"The answer switches with memory: up to {row['from']} {first}, from {row['to']} on {second}"
            f"{_equal(row, lambda size: memory_text(int(size)), measure)}."
        )
    low, high = degrees(row["at_from"]), degrees(row["at_to"])
    head = (
        "With every budget the"
        if len(rows) == budgets
        else f"At {listed([memory_text(r['memory']) for r in rows])} the"
    )
    head = head if budgets > 1 else "The"
    where = f" for {row['camera']}" if row["camera"] not in ("", "camera") else ""
    if low == high:
        return f"{head} answer switches between two views{where}: in {row['from']} {first}, in {row['to']} {second}."
    return (
        f"{head} answer switches at a {row['along']} between {low} and {high}{where}: at {low} {first}, at {high} "
        f"{second}{_equal(row, degrees, measure)}."
    )


def _equal(row: Mapping[str, Any], place: Callable[[float], str], measure: Measure) -> str:
    """The stretch within a switch where both winners are about equal, if there is one."""
    if row["equal_from"] is None:
        return ""
    first, last = place(row["equal_from"]), place(row["equal_to"])
    where = f"at {first}" if first == last else f"from {first} to {last}"
    return f"; {where} both do about as well ({measure.equal_because})"
