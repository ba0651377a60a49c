"""What commands are made of: commands whose options stand in sections, groups that load commands when they are called.

click reads the words. Here stands what it does not do: sections of help, one base for what was given, an option that
is not taken for the value of the one before it, and the nearest name for one that is misspelt.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, TypeAlias

import click

from .nearest import nearest_text

if TYPE_CHECKING:
    from click.shell_completion import CompletionItem

#: The variable by which a shell asks what completes its words.
COMPLETE = "_SHADOWLAB_COMPLETE"
HELP_NAMES = {"help_option_names": ["-h", "--help"]}
#: Loads a command; the module of a command is read when the command is called, or its help.
Loader: TypeAlias = "Callable[[], click.Command]"


class Options(SimpleNamespace):
    """What was given on the command line, by the names of options; None where nothing was."""

    def with_(self, **changes: object) -> Options:
        """The same with other values."""
        return Options(**{**vars(self), **changes})


#: Does the work of a command; the exit status.
Work: TypeAlias = "Callable[[Options], int]"


class Argument(click.Argument):
    """A positional argument with a line of help, which those of click 8.1 have not."""

    def __init__(self, name: str, *, metavar: str, help: str, required: bool = True, **attributes: Any):
        super().__init__([name], metavar=metavar, required=required, **attributes)
        self.record = (metavar, help)

    def get_help_record(self, ctx: click.Context) -> tuple[str, str]:
        """Its name and what it is."""
        return self.record


class Option(click.Option):
    """An option that stands in a section of the help."""

    def __init__(self, *names: str, section: str = "", **attributes: Any):
        super().__init__(names, **attributes)
        self.section = section


def number(text: str | float) -> float:
    """The number of a text; anything else is a mistake of whoever wrote it."""
    try:
        return float(text)
    except ValueError:
        raise click.BadParameter(f"expected a number, got {text!r}") from None


def debug_option() -> Option:
    """Shows where an error comes from; `main` looks for it, wherever it stands."""
    return Option("--debug", is_flag=True, expose_value=False, help="show where an error comes from")


class Command(click.Command):
    """A command that does its work with what was given.

    Parameters
    ----------
    name : str
    work : Callable[[Options], int]
        Its docstring is the description of the command.
    params : iterable of Parameter
    """

    def __init__(self, name: str, work: Work, params: Iterable[click.Parameter] = ()):
        super().__init__(name, params=[*params, debug_option()], help=work.__doc__, context_settings=HELP_NAMES)
        self.work = work

    def invoke(self, ctx: click.Context) -> Any:
        """The exit status of the work; what the context says in its place, if it does."""
        work: Callable[[Options], Any] = ctx.obj or self.work
        # Of what may be repeated click says () where nothing was given.
        given = {
            name: (list(value) or None) if isinstance(value, tuple) else value for name, value in ctx.params.items()
        }
        return work(Options(**given))

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """As click's, but `--out --ground` is an option without its value and not a directory of that name."""
        flags = {name for one in self.get_params(ctx) for name in one.opts if isinstance(one, click.Option)}
        takers = {name for one in self.params if isinstance(one, Option) and not one.is_flag for name in one.opts}
        words = list(args)
        while words:
            word = words.pop(0)
            if word == "--":
                break
            if word in takers and words and words.pop(0) in flags:
                raise click.UsageError(f"Option {word!r} requires an argument.", ctx)
        return super().parse_args(ctx, args)

    def format_help(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Usage, description, and the help of arguments and options, section by section."""
        self.format_usage(ctx, formatter)
        self.format_help_text(ctx, formatter)
        sections: dict[str, list[tuple[str, str]]] = {"Arguments": [], "Options": []}
        for one in self.get_params(ctx):
            record = one.get_help_record(ctx)
            if record is not None:
                section = "Arguments" if isinstance(one, Argument) else getattr(one, "section", "") or "Options"
                sections.setdefault(section, []).append(record)
        for name, rows in sections.items():
            if rows:
                with formatter.section(name):
                    formatter.write_dl(rows)


class Commands(click.Group):
    """Commands that are loaded when they are called.

    Parameters
    ----------
    name : str
    commands : Mapping[str, (str, Loader)]
        Of each its line in the help of the group, and what loads it.
    kind : str
        What the help calls one of them: "COMMAND".
    help : str
    params : sequence of Parameter
    """

    def __init__(
        self,
        name: str,
        commands: Mapping[str, tuple[str, Loader]],
        *,
        kind: str,
        help: str | None,
        params: Sequence[click.Parameter] = (),
    ):
        super().__init__(
            name, params=[*params, debug_option()], help=help, context_settings=HELP_NAMES, invoke_without_command=True,
            no_args_is_help=False, subcommand_metavar=f"{kind} ...", callback=self._called,
        )  # fmt: skip
        self.loaders, self.kind = commands, kind

    def _called(self) -> None:
        ctx = click.get_current_context()
        if ctx.invoked_subcommand is None:
            raise click.UsageError(f"missing {self.kind}: expected one of {', '.join(self.loaders)}", ctx)

    def list_commands(self, ctx: click.Context) -> list[str]:
        """The names of the commands, in the order of the help."""
        return list(self.loaders)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """The command of that name."""
        return self.loaders[cmd_name][1]() if cmd_name in self.loaders else None

    def resolve_command(self, ctx: click.Context, args: list[str]) -> Any:
        """The command that the first word names."""
        if args[0] not in self.loaders:
            raise click.UsageError(f"no such {self.kind} {args[0]!r}; {nearest_text(args[0], self.loaders)}", ctx)
        return super().resolve_command(ctx, args)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """A line for each command, none of which is loaded for it."""
        with formatter.section(f"{self.kind.capitalize()}s"):
            formatter.write_dl([(name, line) for name, (line, _) in self.loaders.items()])

    def shell_complete(self, ctx: click.Context, incomplete: str) -> list[CompletionItem]:
        """The commands that begin so, none of which is loaded for it, and options."""
        from click.shell_completion import CompletionItem

        lines = [(name, line) for name, (line, _) in self.loaders.items() if name.startswith(incomplete)]
        found = [CompletionItem(name, help=line) for name, line in lines]
        return [*found, *click.Command.shell_complete(self, ctx, incomplete)]
