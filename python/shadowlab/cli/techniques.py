"""The command `shadowlab techniques`: what there is by name."""

from __future__ import annotations

from .command import Command, Options


def techniques_command(_: Options) -> int:
    """Lists the techniques with title, source, lights, parameters and their ranges; then the presets of engines."""
    from ..techniques.presets import PRESETS
    from ..techniques.registry import parameter_rows

    previous = None
    for row in parameter_rows():
        if row["name"] != previous:
            space = "" if previous is None else "\n"
            print(f"{space}{row['name']}: {row['title']}\n  {row['source']}\n  lights: {row['lights']}")
        previous = row["name"]
        if row["parameter"]:
            unit = f" {row['unit']}" if row["unit"] else ""
            print(f"  {row['parameter']}={row['default']}{unit} ({row['range']}): {row['doc']}")
    print("\npresets, for directional lights: what engines ship, on the same body and fit")
    for preset in PRESETS:
        print(f"  preset:{preset.name}: {preset.engine}\n    {preset.formula}")
    return 0


TECHNIQUES_COMMAND = Command("techniques", techniques_command)
