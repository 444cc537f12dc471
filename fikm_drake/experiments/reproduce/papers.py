"""The papers that `fikm-drake reproduce` knows."""

from fikm_drake.experiments.reproduce import anfis, fikm, frmrc, integer, labvolt
from fikm_drake.experiments.reproduce.report import Experiment

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

    Raises:
        ValueError: there is no such paper or experiment; the message lists those there are.
    """
    if paper != "all" and paper not in PAPERS:
        raise ValueError(f"no paper {paper!r}; there are: all, {', '.join(PAPERS)}")
    papers = PAPERS if paper == "all" else {paper: PAPERS[paper]}
    found = {
        f"{name} {key}": run
        for name, experiments in papers.items()
        for key, run in experiments.items()
    }
    if not keys:
        return found
    unknown = [key for key in keys if not any(name.endswith(f" {key}") for name in found)]
    if unknown:
        known = ", ".join(key for experiments in papers.values() for key in experiments)
        raise ValueError(f"nothing to reproduce called {', '.join(unknown)}; there are: {known}")
    return {name: run for name, run in found.items() if name.split(" ", 1)[1] in keys}
