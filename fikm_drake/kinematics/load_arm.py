"""Arms from YAML files, as people write their Denavit-Hartenberg tables."""

import ast
import dataclasses
import operator
from collections.abc import Callable
from math import inf, nan, pi
from pathlib import Path

import yaml

from fikm_drake.kinematics.dh_arm import DhArm
from fikm_drake.kinematics.dh_table import DhJoint, DhTable, DhTransform
from fikm_drake.resources import load_model

WORDS = ("type", "flip")
"""Fields of a row that are no numbers."""
WRITTEN = {".inf": inf, "+.inf": inf, "-.inf": -inf, ".nan": nan}
"""Numbers as YAML writes them, in small letters."""
OPERATORS: dict[type, Callable[..., float]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.USub: operator.neg,
    ast.UAdd: operator.pos,
}


def load_arm(name_or_path: str | Path) -> DhArm:
    """Load an arm by the name of one of our models or from a YAML file of your own.

    A number may be an expression of numbers, `pi`, + − * / and brackets:

        name: mine
        convention: standard
        joints:
        - {d: 0.1273, alpha: pi/2, lower: -2*pi, upper: 2*pi}
        - {a: -0.612, flip: true}
        unit: {length: m}

    Args:
        name_or_path: such as `arm7`, or a path that ends in .yaml; `fikm-drake models` lists ours.

    Raises:
        FileNotFoundError: there is no such file; the message lists our models.
        ValueError: the file does not describe an arm; the message names file, joint and field.
    """
    return DhArm(load_model(DhTable, name_or_path, kind="arm", prepare=_evaluate))


def evaluate(text: str) -> float:
    """The value of an expression of numbers, `pi`, + − * / and brackets.

    Raises:
        ValueError: it is another thing; the message names it.
    """
    if text.lower() in WRITTEN:
        return WRITTEN[text.lower()]
    try:
        return _value(ast.parse(text.strip(), mode="eval").body)
    except (SyntaxError, ValueError, ZeroDivisionError, RecursionError, MemoryError):
        raise ValueError(
            f"must be a number or an expression of numbers, pi, + - * / and brackets, got {text!r}"
        ) from None


def _value(node: ast.expr) -> float:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)):
        return float(node.value)
    if isinstance(node, ast.Name) and node.id == "pi":
        return pi
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return OPERATORS[type(node.op)](_value(node.left), _value(node.right))
    if isinstance(node, ast.UnaryOp) and type(node.op) in OPERATORS:
        return OPERATORS[type(node.op)](_value(node.operand))
    raise ValueError


def _evaluate(table: yaml.MappingNode) -> None:
    """Put numbers in the place of expressions, and name what is no field."""
    entries = {key.value: value for key, value in table.value}
    degrees = "deg" in {unit.value for unit in _values(entries.get("unit"), "angle")}
    joints = entries.get("joints")
    if isinstance(joints, yaml.SequenceNode):
        for i, row in enumerate(joints.value, start=1):
            _evaluate_row(row, f"joint {i}", DhJoint, degrees)
    if "tool" in entries:
        _evaluate_row(entries["tool"], "tool", DhTransform, degrees)


def _values(node: yaml.Node | None, name: str) -> list[yaml.Node]:
    pairs = node.value if isinstance(node, yaml.MappingNode) else []
    return [value for key, value in pairs if key.value == name]


def _evaluate_row(row: yaml.Node, where: str, schema: type, degrees: bool) -> None:
    names = [field.name for field in dataclasses.fields(schema)]
    if not isinstance(row, yaml.MappingNode):
        raise ValueError(f"{where} must be a row of {names}, got {row.value!r}")
    for key, value in row.value:
        if key.value == "<<":
            continue
        if key.value not in names:
            raise ValueError(f"{where}: unknown field {key.value!r}, the fields are {names}")
        if key.value in WORDS or value.tag.endswith(":null"):
            continue
        if not isinstance(value, yaml.ScalarNode):
            raise ValueError(f"{where}: {key.value} must be a number, got a list or a table")
        if degrees and "pi" in value.value:
            raise ValueError(
                f"{where}: {key.value} is {value.value!r}, but the table's unit is deg: write degrees"
            )
        try:
            number = evaluate(value.value)
        except ValueError as error:
            raise ValueError(f"{where}: {key.value} {error}") from None
        value.tag, value.style = "tag:yaml.org,2002:float", None
        value.value = repr(number) if abs(number) < inf else f"{number:+}".replace("inf", ".inf")
        value.value = ".nan" if number != number else value.value
