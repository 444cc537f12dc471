"""Runs a scenario in Drake's Simulator."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import Meshcat
from pydrake.math import RotationMatrix
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import Context, OutputPort

from fikm_drake.arrays import Array
from fikm_drake.laws.law import LawLike
from fikm_drake.simulation.log_info import LogInfo, names_of, versions
from fikm_drake.simulation.recorder import POSE_COLUMNS, RowCollector
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.simulation.scenario import BuiltScenario, Scenario, build_scenario
from fikm_drake.simulation.scenario.fingerprint import fingerprint
from fikm_drake.simulation.scenario.surroundings import NO_PAIR

ERROR_COLUMNS = {
    2: ("x_m", "y_m"),
    3: ("x_m", "y_m", "z_m"),
    7: ("rx_rad", "ry_rad", "rz_rad", "x_m", "y_m", "z_m"),
}
"""Columns of the error by the size of the target: turns are rotation vectors in the world."""

FILES = "files"
"""Among the versions in a log: the digest of the files that the scenario names, where it names any."""


class SimulationStopped(RuntimeError):
    """A run ended early; `log` holds the cycles that were done."""

    def __init__(self, log: RunLog, reason: BaseException) -> None:
        cycles = f"{len(log) - 1} of {log.scenario.num_cycles} cycles"
        super().__init__(f"the run stopped after {cycles}: {str(reason) or type(reason).__name__}")
        self.log = log


def simulate(
    scenario: Scenario,
    *,
    law: LawLike | None = None,
    file: str | Path | None = None,
    meshcat: Meshcat | None = None,
    progress: Callable[[float], None] | None = None,
) -> RunLog:
    """Build the Diagram of a scenario, run it in Drake's Simulator and return the log.

    Args:
        scenario: what to run.
        law: another law in place of the controller's own; the log keeps what it calls itself.
        file: a log that grows while the run goes on, and can be read if the process dies; at the end it is
            the whole log, as `RunLog.save` writes it.
        meshcat: shows the run in real time; None: it runs as fast as it can.
        progress: called now and then with the fraction of the run that is done, and with 1 at the end.

    Raises:
        ValueError: the scenario is not valid.
        SimulationStopped: the run was interrupted or failed, or the file cannot be written; the error
            carries the log so far.
    """
    built = build_scenario(scenario, law=law, meshcat=meshcat)
    simulator = Simulator(built.diagram)
    if meshcat is not None:
        simulator.set_target_realtime_rate(1.0)
    root = simulator.get_mutable_context()
    built.set_start(root)
    rows = RowCollector(_info(built, law), file)
    try:
        simulator.Initialize()
        read = _reader(built)
        rows.add(0.0, read(root))
        period, cycles = 1.0 / scenario.control_rate, scenario.num_cycles
        told = 0
        for k in range(1, cycles + 1):
            # To the moment before cycle k: the cycle's own update comes with the next call.
            simulator.AdvanceTo(k * period)
            rows.add(k * period, read(root))
            if progress and 100 * k // cycles > told:
                told = 100 * k // cycles
                progress(k / cycles)
    except (Exception, KeyboardInterrupt) as reason:
        if not len(rows):
            raise
        log = _saved(rows, file, ended=str(reason) or type(reason).__name__)
        raise SimulationStopped(log, reason) from reason
    return _saved(rows, file)


def _saved(rows: RowCollector, file: str | Path | None, ended: str = "") -> RunLog:
    log = rows.log(ended=ended)
    try:
        if file is not None:
            log.save(file)
    except OSError as error:
        raise SimulationStopped(log, error) from error
    finally:
        rows.close()
    return log


def _info(built: BuiltScenario, law: LawLike | None) -> LogInfo:
    """The log's head, with every column's name."""
    chain, size = built.chain, built.motion.size
    units = ["rad" if kind == "revolute" else "m" for kind in chain.kinds]
    joints = [f"{i}_{unit}" for i, unit in enumerate(units, start=1)]
    points = POSE_COLUMNS if size == 7 else ERROR_COLUMNS[size]
    columns = {name: [f"{name}_{point}" for point in points] for name in ("desired", "actual")}
    for name in ("error_before", "error_after"):
        columns[name] = [f"{name}_{column}" for column in ERROR_COLUMNS[size]]
    columns["q"] = [f"q_{joint}" for joint in joints]
    columns["command"] = [f"command_{joint}" for joint in joints]
    columns["velocity"] = [f"velocity_{joint}ps" for joint in joints]
    if not built.is_kinematic:
        torques = ["Nm" if unit == "rad" else "N" for unit in units]
        columns["torque"] = [f"torque_{i}_{unit}" for i, unit in enumerate(torques, start=1)]
    for name, port in built.wired.logged.items():
        count = port.size()
        if name == "joint_step":
            columns[name] = [f"joint_step_{joint}" for joint in joints]
        else:
            columns[name] = [name] if count == 1 else [f"{name}_{i}" for i in range(1, count + 1)]
    if built.wired.status is not None:
        columns["status"] = ["status"]
    names = {}
    if built.wired.statuses and "status" in columns:
        names["status"] = names_of(built.wired.statuses)
    if built.surroundings is not None:
        columns |= {"clearance": ["clearance_m"], "nearest_pair": ["nearest_pair"]}
        pairs = enumerate(built.surroundings.pairs)
        names["nearest_pair"] = {str(NO_PAIR): ""} | {str(i): pair for i, pair in pairs}
    return LogInfo(
        columns,
        scenario=built.scenario.whole().to_yaml(),
        law="" if law is None else repr(law),
        names=names,
        versions=run_versions(built.scenario),
    )


def run_versions(scenario: Scenario) -> dict[str, str]:
    """Versions for the log of a run: those of the process, and a digest of the files (`FILES`)."""
    digest = fingerprint(scenario)
    return versions() | ({FILES: digest} if digest else {})


def _reader(built: BuiltScenario) -> Callable[[Context], list[Array]]:
    """A function that gives the values of a row, in the order of the columns."""
    chain, motion, wired = built.chain, built.motion, built.wired
    previous: dict[str, Array] = {}

    def read(root: Context) -> list[Array]:
        now = root.get_time()
        q = np.array(built.positions(root))
        X = chain.forward_kinematics(q)
        desired = motion.numbers(now)
        before = _error(desired, X)
        after = _error(previous["desired"], X) if previous else before
        command = np.array(_eval(wired.command, root))
        last = previous.get("q", q)
        previous.update(desired=desired, q=q)
        row = [desired, _numbers(X, motion.size), before, after, q, command]
        row.append(_velocity(built, root, (q - last) * built.scenario.control_rate))
        row += _torque(built, root)
        logged = {name: _eval(port, root) for name, port in wired.logged.items()}
        row += logged.values()
        if wired.status is not None:
            row.append(np.array([wired.status(logged, before)]))
        if built.surroundings is not None:
            nearest = built.surroundings.nearest(built.all_positions(root))
            row += [np.array([number]) for number in nearest]
        return row

    return read


def _velocity(built: BuiltScenario, root: Context, difference: Array) -> Array:
    """Velocity of the plant's joints; of a kinematic run the commanded one, or the last change of q."""
    if not built.is_kinematic:
        own = built.plant.GetMyContextFromRoot(root)
        return built.plant.GetVelocities(own)[built.chain.velocity_indices]
    return difference if built.wired.velocity is None else _eval(built.wired.velocity, root)


def _torque(built: BuiltScenario, root: Context) -> Iterator[Array]:
    """What acts in the joints; nothing in a kinematic run."""
    if built.is_kinematic:
        return
    plant, indices = built.plant, built.chain.velocity_indices
    actuation = _eval(plant.get_net_actuation_output_port(), root)
    yield (plant.MakeActuationMatrix() @ actuation)[indices]


def _eval(port: OutputPort, root: Context) -> Array:
    return port.Eval(port.get_system().GetMyContextFromRoot(root))


def _error(desired: Array, X: Array) -> Array:
    """Desired less actual: positions [m], after the rotation vector [rad] of a pose."""
    if len(desired) < 7:
        return desired - X[: len(desired), 3]
    wanted = RotationMatrix(Quaternion(desired[:4] / np.linalg.norm(desired[:4])))
    turn = (wanted @ RotationMatrix(X[:3, :3]).inverse()).ToAngleAxis()
    return np.concatenate([turn.angle() * turn.axis(), desired[4:] - X[:3, 3]])


def _numbers(X: Array, size: int) -> Array:
    """The tool in the coordinates of the target."""
    if size < 7:
        return X[:size, 3]
    return np.concatenate([RotationMatrix(X[:3, :3]).ToQuaternion().wxyz(), X[:3, 3]])
