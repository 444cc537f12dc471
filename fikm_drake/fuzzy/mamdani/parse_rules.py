"""Rules written as sentences."""

import re

from fikm_drake.fuzzy.fuzzy_variable import NOT
from fikm_drake.fuzzy.mamdani.mamdani_config import FuzzyRule, MamdaniConfig

SENTENCE = "IF x is A AND y is not B THEN z is C"


def parse_rules(text: str, config: MamdaniConfig | None = None) -> list[FuzzyRule]:
    """Rules from text, one a line; what `MamdaniSystem.rules` prints reads back as the same rules.

        rules = fd.parse_rules('''
            IF distance is near AND speed is not low THEN brake is hard
            IF distance is far OR speed is low THEN brake is soft, horn is off
        ''')

    Keywords may be in small letters, labels are as they are and may have spaces. Empty lines and what
    follows a `#` are skipped.

    Args:
        text: the lines.
        config: variables that the rules are about; None: names and labels are not looked up.

    Raises:
        ValueError: naming the line, its number, and the bad name or label with the valid ones.
    """
    rules = []
    for number, line in enumerate(text.splitlines(), start=1):
        sentence = line.partition("#")[0].strip()
        if not sentence:
            continue
        where = f"line {number}, {sentence!r}"
        rule = _rule(where, sentence)
        if config is not None:
            known = [(v.name, v.labels) for v in config.inputs]
            _check(where, {k: v.removeprefix(NOT) for k, v in rule.when.items()}, dict(known))
            _check(where, rule.then, {v.name: v.labels for v in config.outputs})
        rules.append(rule)
    if not rules:
        raise ValueError(f"the text has no rule such as {SENTENCE!r}")
    return rules


def _rule(where: str, sentence: str) -> FuzzyRule:
    found = re.fullmatch(r"IF\s+(.+?)\s+THEN\s+(.+)", sentence, flags=re.IGNORECASE)
    if not found:
        raise ValueError(f"{where}: must read as {SENTENCE!r}")
    when, then = found.groups()
    joins = {word.lower() for word in re.findall(r"\s(AND|OR)\s", when, flags=re.IGNORECASE)}
    if len(joins) > 1:
        raise ValueError(f"{where}: `and` and `or` in one rule; make two of it")
    premises = re.split(r"\s+(?:AND|OR)\s+", when, flags=re.IGNORECASE)
    conclusions = re.split(r"\s*,\s*|\s+AND\s+", then, flags=re.IGNORECASE)
    return FuzzyRule(
        _parts(where, premises, negation=True),
        _parts(where, conclusions, negation=False),
        *joins,
    )


def _parts(where: str, parts: list[str], *, negation: bool) -> dict[str, str]:
    labels: dict[str, str] = {}
    for part in parts:
        found = re.fullmatch(r"(.+?)\s+is\s+(not\s+)?(.+)", part, flags=re.IGNORECASE)
        if not found:
            raise ValueError(f"{where}: {part!r} must read as 'x is A'")
        name, negated, label = found.groups()
        if negated and not negation:
            raise ValueError(f"{where}: a conclusion cannot be {negated + label!r}")
        if name in labels:
            raise ValueError(f"{where}: {name!r} stands twice")
        labels[name] = NOT + label if negated else label
    return labels


def _check(where: str, labels: dict[str, str], known: dict[str, tuple[str, ...]]) -> None:
    for name, label in labels.items():
        if name not in known:
            raise ValueError(f"{where}: no variable {name!r}; there are: {', '.join(known)}")
        if label not in known[name]:
            raise ValueError(
                f"{where}: {name!r} has no label {label!r}; there are: {', '.join(known[name])}"
            )
