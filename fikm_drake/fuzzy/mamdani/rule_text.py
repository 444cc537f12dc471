"""Rules to read."""

from fikm_drake.fuzzy.fuzzy_variable import FuzzyVariable
from fikm_drake.fuzzy.mamdani.mamdani_config import MamdaniConfig
from fikm_drake.fuzzy.rule_base import aligned

HOLE = "-"


def rule_lines(config: MamdaniConfig) -> list[str]:
    """Rules such as `IF x is A AND y is not B THEN z is C`."""
    return [
        f"IF {_parts(config.inputs, rule.when, f' {rule.join.upper()} ')} "
        f"THEN {_parts(config.outputs, rule.then, ', ')}"
        for rule in config.rules
    ]


def rule_table(config: MamdaniConfig) -> str:
    """One line a rule: its number and the label of each variable; empty where it has none."""
    names = [variable.name for variable in [*config.inputs, *config.outputs]]
    rows = [["rule", *names]]
    for number, rule in enumerate(config.rules, start=1):
        labels = {**rule.when, **rule.then}
        join = " (or)" if rule.join == "or" else ""
        rows.append([f"{number}{join}", *(labels.get(name, "") for name in names)])
    return aligned(rows)


def rule_grid(config: MamdaniConfig, output: str | None) -> str:
    """A grid of two inputs: rows follow the first, a cell has the labels that rules conclude on.

    Raises:
        ValueError: there are not two inputs, or no such output.
    """
    if len(config.inputs) != 2:
        raise ValueError(f"a grid needs two inputs, got {len(config.inputs)}")
    name = config.output(output).name
    first, second = config.inputs
    rows = [[f"{first.name} \\ {second.name}", *second.labels]]
    for a in first.labels:
        cells = [a]
        for b in second.labels:
            case = {first.name: a, second.name: b}
            held = [
                rule.then[name] for rule in config.rules if name in rule.then and rule.holds(case)
            ]
            cells.append("/".join(dict.fromkeys(held)) or HOLE)
        rows.append(cells)
    return aligned(rows)


def _parts(variables: list[FuzzyVariable], labels: dict[str, str], joint: str) -> str:
    return joint.join(f"{v.name} is {labels[v.name]}" for v in variables if v.name in labels)
