"""The commands, each with its line in the help; none is loaded before it is called."""

from __future__ import annotations

import click

from .command import Commands, Option


def _demo() -> click.Command:
    from .demo import DEMO

    return DEMO


def _compare() -> click.Command:
    from .compare import COMPARE

    return COMPARE


def _advise() -> click.Command:
    from .advise import ADVISE

    return ADVISE


def _explain() -> click.Command:
    from .explain import EXPLAIN

    return EXPLAIN


def _sweep() -> click.Command:
    from .sweep import SWEEP

    return SWEEP


def _experiment() -> click.Command:
    from .experiment import EXPERIMENT

    return EXPERIMENT


def _matrix() -> click.Command:
    from .matrix import MATRIX

    return MATRIX


def _diagnose() -> click.Command:
    from .diagnose import DIAGNOSE

    return DIAGNOSE


def _techniques() -> click.Command:
    from .techniques import TECHNIQUES_COMMAND

    return TECHNIQUES_COMMAND


def _doctor() -> click.Command:
    from .doctor import DOCTOR

    return DOCTOR


def _check() -> click.Command:
    from .check import CHECK

    return CHECK


def _completion() -> click.Command:
    from .completion import COMPLETION

    return COMPLETION


def _say_version(ctx: click.Context, param: click.Parameter, value: bool) -> None:
    if value:
        from .._core import __version__

        click.echo(f"shadowlab {__version__}")
        ctx.exit()


SHADOWLAB = Commands(
    "shadowlab",
    {
        "demo": ("a first look, in seconds: two techniques on a bundled scene", _demo),
        "compare": ("techniques side by side, against traced truth", _compare),
        "advise": ("which technique is best at equal memory, and where that switches", _advise),
        "explain": ("why a pixel is wrong, and what would mend it", _explain),
        "sweep": ("a space of scenes, views, techniques and settings, run by run", _sweep),
        "check": ("a gate for continuous integration: techniques or matrices against bounds", _check),
        "experiment": ("published experiments, made again", _experiment),
        "matrix": ("the matrix of a technique", _matrix),
        "diagnose": ("what sets two shadow matrices apart", _diagnose),
        "techniques": ("the techniques and their parameters", _techniques),
        "doctor": ("what is here, what is missing, and how to get it", _doctor),
        "completion": ("the script with which a shell completes commands, options and names", _completion),
    },
    kind="COMMAND",
    help="The laboratory for shadow-map parameterizations.",
    params=[
        Option(
            "--version", is_flag=True, is_eager=True, expose_value=False, callback=_say_version,
            help="show the version",
        ),
    ],
)  # fmt: skip
