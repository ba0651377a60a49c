"""The command `shadowlab completion`, and the answer that a shell gets where it asks."""

from __future__ import annotations

import os

import click
from click.shell_completion import BashComplete, add_completion_class, shell_complete, split_arg_string

from .command import COMPLETE, Argument, Command, Options

SHELLS = ("bash", "zsh", "fish")


class WholeWords(BashComplete):
    """Completion by bash of words with : = and @ in them, at which bash divides what it hands over and what it puts in.

    The line is handed over as a whole; what stands before the last of these letters is taken off the answers again.
    """

    source_template = """\
%(complete_func)s() {
    local line=${COMP_LINE:0:COMP_POINT} IFS=$'\\n' type value answer head
    local word=${line##* }
    [[ $word == -*=* ]] && word=${word#*=}
    head=${word%%"${word##*[:=@]}"}
    COMPREPLY=()
    for answer in $(COMP_LINE=$line %(complete_var)s=bash_complete "$1"); do
        IFS=, read -r type value <<< "$answer"
        case $type in
            dir) compopt -o dirnames ;;
            file) compopt -o default ;;
            *) COMPREPLY+=("${value#"$head"}"); [[ $value == *= ]] && compopt -o nospace ;;
        esac
    done
}
complete -o nosort -F %(complete_func)s %(prog_name)s
"""

    def get_completion_args(self) -> tuple[list[str], str]:
        """The words before the cursor, and the one that it stands in."""
        line = os.environ["COMP_LINE"]
        words = split_arg_string(line)[1:]
        return (words, "") if not words or line[-1:].isspace() else (words[:-1], words[-1])


def complete(commands: click.Command, instruction: str) -> int:
    """Answers a shell: the script for `bash_source`, what completes its words for `bash_complete`."""
    add_completion_class(WholeWords)
    return shell_complete(commands, {}, "shadowlab", COMPLETE, instruction)


def completion_command(options: Options) -> int:
    """Prints the script with which a shell completes commands, options, scenes, techniques and filters.

    bash: eval "$(shadowlab completion bash)" in ~/.bashrc. zsh: the same with zsh in ~/.zshrc. fish: shadowlab
    completion fish > ~/.config/fish/completions/shadowlab.fish
    """
    return complete(click.Command("shadowlab"), f"{options.shell}_source")


COMPLETION = Command(
    "completion",
    completion_command,
    [Argument("shell", metavar="bash|zsh|fish", type=click.Choice(SHELLS), help="the shell")],
)
