"""Mamdani inference, ours beside scikit-fuzzy's (`fikm-drake benchmark mamdani`)."""

import dataclasses
import time
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from statistics import median

import numpy as np

from fikm_drake.arrays import Array
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.fuzzy.fuzzy_variable import NOT, FuzzyVariable
from fikm_drake.fuzzy.mamdani import MamdaniConfig, MamdaniSystem, load_mamdani

SYSTEM = "labvolt_theta3"
"""Table 1 of Elsharif et al.: two inputs, nine rules, one output."""
OURS, PEER = "fikm_drake", "scikit-fuzzy"
CASES = (("maximum", "centroid"), ("maximum", "mean_of_maximum"), ("sum", "mean_of_maximum"))
"""Aggregation and defuzzification; the last is the paper's, of which the peer has no sum."""
PEER_METHODS = {"centroid": "centroid", "mean_of_maximum": "mom"}

Evaluate = Callable[[Array], Array]


@dataclass(frozen=True)
class InferenceCost:
    """One engine on one kind of inference."""

    aggregation: str
    """`maximum` or `sum`."""
    defuzzification: str
    """`centroid` or `mean_of_maximum`."""
    engine: str
    """`OURS` or `PEER`."""
    single: float
    """Median CPU time of an evaluation of one point [µs]."""
    batch: float
    """Median CPU time a point of one evaluation of many [µs]."""
    difference: float
    """Median distance of its outputs from ours, as a fraction of the range [-]."""


def mamdani_benchmark(
    *,
    rounds: int = 10,
    singles: int = 20,
    points: int = 2000,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> list[InferenceCost]:
    """Time inferences of random points, one by one and as an array.

    Each round has points of its own, so that the peer's cache of results is of no use to it. The
    engines take turns, so that a noisy machine disturbs them alike.

    Args:
        rounds: how often.
        singles: points of a round that are evaluated one by one.
        points: points of a round that are evaluated as an array.
        seed: of the points.
        progress: called after each round with the fraction done.

    Raises:
        ValueError: a number is not positive.
    """
    for name, value in (("rounds", rounds), ("singles", singles), ("points", points)):
        if value < 1:
            raise ValueError(f"{name} must be positive, got {value}")
    engines = _engines()
    config = load_mamdani(SYSTEM).config
    width = config.outputs[0].upper - config.outputs[0].lower
    rng = np.random.default_rng(seed)
    runs: dict[tuple[str, str, str], list[tuple[float, float, float]]] = {
        key: [] for key in engines
    }
    for k in range(rounds):
        X = _points(config, points, rng)
        for aggregation, defuzzification in CASES:
            ours = engines[aggregation, defuzzification, OURS](X)
            for engine in (OURS, PEER):
                key = (aggregation, defuzzification, engine)
                if key in engines:
                    one, many, values = _timed(engines[key], X, singles)
                    away = float(np.median(np.abs(values - ours))) / width
                    runs[key].append((one, many, away))
        if progress:
            progress((k + 1) / rounds)
    return [
        InferenceCost(*key, *(median(column) for column in zip(*done)))
        for key, done in runs.items()
    ]


def sampling_error(*, points: int = 5000, seed: int = 0) -> tuple[float, float]:
    """Median and greatest error of the centroid of a maximum, as a fraction of the range [-].

    It is the one that is sampled; the error is against a hundred times as many samples.
    """
    config = dataclasses.replace(
        load_mamdani(SYSTEM).config, aggregation="maximum", defuzzification="centroid"
    )
    fine = dataclasses.replace(config, samples=100 * config.samples)
    X = _points(config, points, np.random.default_rng(seed))
    error = np.abs(MamdaniSystem(config)(X).values - MamdaniSystem(fine)(X).values)
    error /= config.outputs[0].upper - config.outputs[0].lower
    return float(np.median(error)), float(np.max(error))


def table(rounds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    costs = mamdani_benchmark(rounds=rounds, progress=progress)
    middle, greatest = sampling_error()
    sampled = (
        f"sampled centroid off by {middle:.1e} of the range (median), {greatest:.1e} (greatest)"
    )
    peers = {cost.defuzzification: cost for cost in costs if cost.engine == PEER}
    lines = ["Table 1 of Elsharif et al., 2 inputs and 9 rules: CPU time of a point (median)"]
    lines += [
        f"  {cost.engine:12s} {cost.aggregation:7s} {cost.defuzzification:15s}"
        f" alone {cost.single:7.1f} µs  in an array {cost.batch:6.2f} µs"
        for cost in costs
    ]
    if not peers:
        lines += [sampled, "scikit-fuzzy is not installed: nothing to compare with"]
        return BenchmarkTable(lines, costs)
    lines.append("times faster than scikit-fuzzy, which has no sum: there, than its maximum")
    for ours in costs:
        if ours.engine == OURS:
            peer = peers[ours.defuzzification]
            lines.append(
                f"  {ours.aggregation:7s} {ours.defuzzification:15s} alone"
                f" {peer.single / ours.single:.0f}x, our array than its points alone"
                f" {peer.single / ours.batch:.0f}x, than its array {peer.batch / ours.batch:.0f}x"
            )
    apart = ", ".join(f"{peer.difference:.1e} ({name})" for name, peer in peers.items())
    lines += [f"outputs apart, median, of the range: {apart}", sampled]
    return BenchmarkTable(lines, costs)


def _timed(evaluate: Evaluate, X: Array, singles: int) -> tuple[float, float, Array]:
    """CPU time of one point and of a point among many [µs], and the outputs."""
    start = time.process_time()
    for x in X[:singles]:
        evaluate(x)
    one = (time.process_time() - start) / singles
    start = time.process_time()
    values = evaluate(X)
    many = (time.process_time() - start) / len(X)
    return 1e6 * one, 1e6 * many, values


def _points(config: MamdaniConfig, count: int, rng: np.random.Generator) -> Array:
    """Uniform in the ranges of the inputs, shape (count, inputs)."""
    lower, upper = ([getattr(v, end) for v in config.inputs] for end in ("lower", "upper"))
    return rng.uniform(lower, upper, (count, len(config.inputs)))


def _engines() -> dict[tuple[str, str, str], Evaluate]:
    """What evaluates points (..., inputs), by aggregation, defuzzification and engine; warmed up."""
    engines: dict[tuple[str, str, str], Evaluate] = {}
    base = load_mamdani(SYSTEM).config
    for aggregation, method in CASES:
        config = dataclasses.replace(base, aggregation=aggregation, defuzzification=method)
        engines[aggregation, method, OURS] = _ours(config)
        if find_spec("skfuzzy") and aggregation == "maximum":
            engines[aggregation, method, PEER] = _peer(config)
    for evaluate in engines.values():
        evaluate(np.array([0.3, 0.2]))
    return engines


def _ours(config: MamdaniConfig) -> Evaluate:
    system = MamdaniSystem(config)
    return lambda x: system(x).values[..., 0]


def _universe(variable: FuzzyVariable, config: MamdaniConfig) -> Array:
    return np.linspace(variable.lower, variable.upper, config.samples)


def _peer(config: MamdaniConfig) -> Evaluate:
    """The same system of scikit-fuzzy, with as many samples."""
    control = import_module("skfuzzy.control")
    method = PEER_METHODS[config.defuzzification]
    inputs = {v.name: control.Antecedent(_universe(v, config), v.name) for v in config.inputs}
    outputs = {
        v.name: control.Consequent(_universe(v, config), v.name, defuzzify_method=method)
        for v in config.outputs
    }
    variables = {**inputs, **outputs}
    for variable in [*config.inputs, *config.outputs]:
        for label, shape in variable.memberships.items():
            variables[variable.name][label] = shape(_universe(variable, config))
    rules = []
    for rule in config.rules:
        first, second = (
            ~variables[name][label.removeprefix(NOT)] if NOT in label else variables[name][label]
            for name, label in rule.when.items()
        )
        ((name, label),) = rule.then.items()
        rules.append(control.Rule(first & second, variables[name][label]))
    system = control.ControlSystem(rules)
    simulations = {ndim: control.ControlSystemSimulation(system) for ndim in (1, 2)}
    output = config.outputs[0].name

    def evaluate(x: Array) -> Array:
        simulation = simulations[x.ndim]
        for variable, column in zip(config.inputs, np.moveaxis(x, -1, 0)):
            simulation.input[variable.name] = column
        simulation.compute()
        return simulation.output[output]

    return evaluate
