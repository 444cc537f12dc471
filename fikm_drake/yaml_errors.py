"""What is wrong with a YAML file, told to its author: the line, the word, and what would be right."""

import dataclasses
import re
from collections.abc import Iterator
from difflib import get_close_matches
from typing import Any, get_args

import yaml

UNKNOWN = re.compile(r"The fields \[(.*)\] were unknown to the schema")
CONVERSION = re.compile(
    r"(?:could not convert string to float|invalid literal for int\(\) with base 10): '(.*)'"
)
CLASS = re.compile(r"<class '(?:[^']*\.)?(\w+)'>")


def explain(error: Exception, schema: type, tree: yaml.Node | None) -> str:
    """An error of Drake's typed YAML in words for the author of the file.

    Args:
        error: what was raised.
        schema: the dataclass that the file should fit.
        tree: of the file; None: it has none, the error is of YAML itself.
    """
    text = CLASS.sub(r"\1", str(error))
    if tree is None:
        return text
    if unknown := UNKNOWN.search(text):
        names = re.findall(r"'([^']*)'", unknown[1])
        return "; ".join(_unknown(name, schema, tree) for name in names)
    if found := CONVERSION.search(text):
        return _no_number(found[1], tree) or text
    return text


def _unknown(name: str, schema: type, tree: yaml.Node) -> str:
    """What an unknown option may have been meant to be: one of its own class."""
    for line, owner in _strangers(name, tree, schema):
        options = [item.name for item in dataclasses.fields(owner)]
        near = get_close_matches(name, options, n=1)
        meant = f"did you mean {near[0]!r}? " if near else ""
        return f"line {line}: unknown option {name!r}; {meant}{owner.__name__} has {', '.join(options)}"
    return f"unknown option {name!r}"


def _strangers(name: str, node: yaml.Node, kind: object) -> Iterator[tuple[int, Any]]:
    """Lines where a key stands that its mapping's dataclass has not, and that class.

    Args:
        name: the key.
        node: the tree.
        kind: the type that it should have.
    """
    if isinstance(node, yaml.SequenceNode):
        for value in node.value:
            for inner in get_args(kind):
                yield from _strangers(name, value, inner)
    if not isinstance(node, yaml.MappingNode):
        return
    classes = [cls for cls in (kind, *get_args(kind)) if dataclasses.is_dataclass(cls)]
    tagged = [cls for cls in classes if getattr(cls, "__name__", "") == node.tag.removeprefix("!")]
    for owner in (tagged or classes)[:1]:  # without a tag Drake takes the first
        fields = {item.name: item.type for item in dataclasses.fields(owner)}
        for key, value in node.value:
            if key.value in fields:
                yield from _strangers(name, value, fields[key.value])
            elif key.value == name:
                yield key.start_mark.line + 1, owner


def _mappings(node: yaml.Node) -> Iterator[yaml.MappingNode]:
    """Every mapping of a tree."""
    if isinstance(node, yaml.MappingNode):
        yield node
    children = [v for _, v in node.value] if isinstance(node, yaml.MappingNode) else node.value
    if not isinstance(node, yaml.ScalarNode):
        for value in children:
            yield from _mappings(value)


def _no_number(word: str, tree: yaml.Node) -> str:
    """Where a word stands that should be a number; empty: it was not found.

    Of a word where numbers should be in a list, Drake names the first letter.
    """
    for mapping in _mappings(tree):
        for key, value in mapping.value:
            for node in [value, *(value.value if isinstance(value, yaml.SequenceNode) else [])]:
                text = node.value if isinstance(node, yaml.ScalarNode) else None
                if text and (text == word or (len(word) == 1 and text.startswith(word))):
                    line = node.start_mark.line + 1
                    return f"line {line}: {key.value} must be made of numbers, got {text!r}"
    return ""
