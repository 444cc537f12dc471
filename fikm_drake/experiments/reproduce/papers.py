"""The papers that `fikm-drake reproduce` knows, and the page that maps them to files and verdicts."""

from fikm_drake.experiments.reproduce import anfis, fikm, frmrc, integer, labvolt
from fikm_drake.experiments.reproduce.catalogue import aliases, catalogue
from fikm_drake.experiments.reproduce.report import Experiment, Section

MODULES = {"fikm": fikm, "anfis": anfis, "frmrc": frmrc, "labvolt": labvolt, "integer": integer}
PAPERS: dict[str, dict[str, Experiment]] = {
    "fikm": fikm.EXPERIMENTS,
    "anfis": anfis.EXPERIMENTS,
    "frmrc": frmrc.EXPERIMENTS,
    "labvolt": labvolt.EXPERIMENTS,
    "integer": integer.EXPERIMENTS,
}
"""Experiments of each paper by name."""


def select(paper: str, keys: list[str]) -> dict[str, Experiment]:
    """The experiments of a paper, or of `all`, that `keys` name; all of them for no keys.

    A key is a part's own, or any table or figure number of the paper.

    Raises:
        ValueError: there is no such paper or experiment; the message lists those there are.
    """
    found: dict[str, Experiment] = {}
    known: list[str] = []
    unknown = set(keys)
    for name in _papers(paper):
        parts = PAPERS[name]
        others = aliases(name) if name in catalogue() else {}
        known += [*parts, *(key for key in others if key not in parts)]
        wanted = keys or list(parts)
        for key in wanted:
            part = key if key in parts else others.get(key)
            if part in parts:
                found[f"{name} {part}"] = parts[part]
                unknown.discard(key)
    if unknown:
        raise ValueError(
            f"nothing to reproduce called {', '.join(sorted(unknown))}; there are: "
            f"{', '.join(dict.fromkeys(known))}"
        )
    return found


def listing(paper: str) -> str:
    """All keys of a paper, or of `all`, a line a part: its tables and figures, and what it shows."""
    lines = []
    for name in _papers(paper):
        others = aliases(name)
        lines.append(f"{name}:")
        for part, run in PAPERS[name].items():
            also = [key for key, target in others.items() if target == part and key != part]
            text = (run.__doc__ or "").strip().splitlines()[0]
            lines.append(f"  {part:14s} {text}" + (f" Also: {', '.join(also)}." if also else ""))
    return "\n".join(lines)


def page(verdicts: dict[str, Section]) -> str:
    """The map of all papers as Markdown.

    Args:
        verdicts: sections that were run, by paper and key (`fikm table 6`); others get no verdict.
    """
    text = [
        "# The five papers, item by item",
        "",
        "Written by `fikm-drake reproduce all --map notebooks/papers.md`, which runs every part; `not run`:",
        "the command in that row tells. A verdict counts the",
        "cells that claim something; `told` is judged by the paper's figure without a claim of ours, such",
        "as tracking errors before the step.",
    ]
    for paper, items in catalogue().items():
        head = (MODULES[paper].__doc__ or "").strip().splitlines()[0].split("(`")[0].strip()
        text += ["", f"## {head.rstrip(':')}", "", "| item | what | where | command | verdict |"]
        text.append("|---|---|---|---|---|")
        for item in items:
            module, name = item.where.split(":")
            path = f"fikm_drake/{module.replace('.', '/')}.py"
            command = f'`fikm-drake reproduce {paper} --only "{item.part}"`'
            verdict = _verdict(verdicts.get(f"{paper} {item.part}"))
            names = ", ".join(item.names)
            text.append(
                f"| {names} | {item.what} | [`{name}`](../{path}) | {command} | {verdict} |"
            )
    return "\n".join([*text, ""])


def _verdict(section: Section | None) -> str:
    if section is None:
        return "not run"
    claims = [
        c for c in section.cells if (c.reached, c.before_reached)[c.claimed == "before"] is not None
    ]
    failed = sum(cell.failed for cell in claims)
    told = [verdict for cell in section.cells for verdict in cell.verdicts]
    words = (
        [f"{len(claims) - failed} of {len(claims)} claims hold"]
        if claims
        else ["shown, nothing claimed"]
    )
    meets, misses = told.count("meets"), told.count("misses")
    if meets or misses:
        words.append(f"told: {meets} meet, {misses} miss")
    return "; ".join(words)


def _papers(paper: str) -> list[str]:
    if paper != "all" and paper not in PAPERS:
        raise ValueError(f"no paper {paper!r}; there are: all, {', '.join(PAPERS)}")
    return list(PAPERS) if paper == "all" else [paper]
