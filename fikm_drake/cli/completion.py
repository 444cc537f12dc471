"""`fikm-drake completion`: what the Tab key offers in bash, zsh and fish.

The words are read from the parsers of the commands themselves, so that a new command or option needs no
line here. Of values, those with choices are offered, else files.
"""

import argparse
from shlex import quote
from typing import NamedTuple

from fikm_drake.cli.shared import OK
from fikm_drake.resources import model_names

NAMES = {"scenario": "scenarios", "arm": "", "system": "fuzzy"}
"""Arguments that take the name of a model, and the folder of `models/` that it is in."""


class Level(NamedTuple):
    """What may follow the words of a command, such as `train bounds`."""

    words: dict[str, str]
    """Subcommands and names, each with its help."""
    options: dict[str, str]
    """Options, each with its help."""


def add_completion(commands: "argparse._SubParsersAction") -> None:
    """Add the command."""
    completion = commands.add_parser(
        "completion",
        help="print a script that completes commands and options",
        description="""bash: eval "$(fikm-drake completion bash)" in ~/.bashrc; zsh alike in ~/.zshrc;
        fish: fikm-drake completion fish > ~/.config/fish/completions/fikm-drake.fish""",
    )
    completion.add_argument("shell", choices=tuple(WRITERS))
    completion.set_defaults(run=lambda options: _completion(options, commands))


def _completion(
    options: argparse.Namespace, commands: "argparse._SubParsersAction[argparse.ArgumentParser]"
) -> int:
    top = Level(_subcommands(commands), {"--help": "show help", "--version": "show the version"})
    levels = {"": top}
    for name, parser in commands.choices.items():
        _collect(name, parser, levels)
    print(WRITERS[options.shell](levels))
    return OK


def _collect(path: str, parser: argparse.ArgumentParser, levels: dict[str, Level]) -> None:
    """Enter a parser and those below it into the levels."""
    words: dict[str, str] = {}
    options: dict[str, str] = {}
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            words |= _subcommands(action)
            for name, child in action.choices.items():
                _collect(f"{path} {name}", child, levels)
        elif action.option_strings:
            options[action.option_strings[-1]] = action.help or ""
        elif action.choices is not None:
            words |= {str(choice): "" for choice in action.choices}
        elif action.dest in NAMES:
            words |= {name: "" for name in model_names(NAMES[action.dest])}
    levels[path] = Level(words, options)


def _subcommands(action: "argparse._SubParsersAction[argparse.ArgumentParser]") -> dict[str, str]:
    texts = {choice.dest: choice.help or "" for choice in action._choices_actions}
    return {name: texts.get(name, "") for name in action.choices}


def _bash(levels: dict[str, Level]) -> str:
    commands = "|".join(quote(path) for path in levels if path)
    cases = "\n".join(
        f"        {quote(path)}) words={quote(' '.join(level.words))}"
        f" options={quote(' '.join(level.options))} ;;"
        for path, level in levels.items()
    )
    return f"""# fikm-drake: completion for bash
_fikm_drake() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" path="" longer word words options
    for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
        longer="${{path:+$path }}$word"
        case "$longer" in {commands}) path=$longer ;; esac
    done
    case "$path" in
{cases}
    esac
    [[ $current == -* ]] && words=$options
    COMPREPLY=($(compgen -W "$words" -- "$current"))
    [[ $current == -* || -z $path ]] || COMPREPLY+=($(compgen -f -- "$current"))
}}
complete -o filenames -F _fikm_drake fikm-drake"""


def _zsh(levels: dict[str, Level]) -> str:
    return f"autoload -U +X compinit bashcompinit && compinit && bashcompinit\n{_bash(levels)}"


def _fish(levels: dict[str, Level]) -> str:
    lines = ["# fikm-drake: completion for fish"]
    for path, level in levels.items():
        seen = [f"__fish_seen_subcommand_from {word}" for word in path.split()]
        first = "__fish_use_subcommand"
        condition = "; and ".join(seen) if seen else first
        below = [p.split()[-1] for p in levels if path and p.startswith(f"{path} ")]
        if below:
            first = f"{condition}; and not __fish_seen_subcommand_from {' '.join(below)}"
        else:
            first = condition
        start = f"complete -c fikm-drake -n {quote(first)}"
        for word, text in level.words.items():
            lines.append(f"{start} -a {quote(word)} -d {quote(text)}")
        start = f"complete -c fikm-drake -n {quote(condition)}"
        for option, text in level.options.items():
            lines.append(f"{start} -l {option.lstrip('-')} -d {quote(text)}")
    return "\n".join(lines)


WRITERS = {"bash": _bash, "zsh": _zsh, "fish": _fish}
"""Shells by name."""
