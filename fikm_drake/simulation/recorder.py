"""Any Diagram's signals, into the same log as a scenario's."""

import functools
from collections.abc import Callable, Iterable, Mapping
from enum import IntEnum
from pathlib import Path

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    Context,
    Diagram,
    DiagramBuilder,
    EventStatus,
    LeafSystem,
    OutputPort,
    PortDataType,
)

from fikm_drake.arrays import Array
from fikm_drake.checks import check_positive_finite
from fikm_drake.control.status import ControllerStatus
from fikm_drake.simulation.log_file import GrowingLog
from fikm_drake.simulation.log_info import LogInfo, names_of, versions
from fikm_drake.simulation.run_log import RunLog
from fikm_drake.solvers.labvolt.solution import LabVoltStatus
from fikm_drake.solvers.redundancy.resolution import ResolutionStatus
from fikm_drake.systems.integer_fuzzy_ik_system import IntegerFuzzyIkStatus

Ports = Iterable[OutputPort] | Mapping[str, OutputPort] | None
STATUSES: dict[str, type[IntEnum]] = {
    "FuzzyIkController": ControllerStatus,
    "FusedFuzzyIk": ControllerStatus,
    "FuzzyIkTorqueController": ControllerStatus,
    "LabVoltIk": LabVoltStatus,
    "RedundancyIk": ResolutionStatus,
    "IntegerFuzzyIkSystem": IntegerFuzzyIkStatus,
}
"""What the port `status` of our systems means, by the name of the class."""
POSE_COLUMNS = ("qw", "qx", "qy", "qz", "x_m", "y_m", "z_m")


class RowCollector:
    """Rows of a run, in memory and, where there is a file, in it as they come."""

    def __init__(self, info: LogInfo, file: str | Path | None = None) -> None:
        self.info = info
        self._table = np.empty((256, 1 + info.width))
        self._count = 0
        self._file = GrowingLog(file, info) if file is not None else None

    def __len__(self) -> int:
        return self._count

    @property
    def last_time(self) -> float:
        """Time of the last row [s]."""
        return float(self._table[self._count - 1, 0])

    def add(self, time: float, values: Iterable[Array]) -> None:
        """Take a row; one of the same time as the last takes its place in memory."""
        again = self._count and time <= self._table[self._count - 1, 0]
        if not again and self._count == len(self._table):
            self._table = np.concatenate([self._table, np.empty_like(self._table)])
        self._count += not again
        row = self._table[self._count - 1]
        row[0] = time
        np.concatenate([*values], out=row[1:])
        if self._file is not None and not again:
            self._file.append(row.copy())

    def log(self, *, ended: str = "") -> RunLog:
        """The log so far.

        Raises:
            ValueError: there is no row yet.
        """
        if self._file is not None:
            self._file.flush()
        self.info.ended = ended
        return RunLog.from_table(self.info, self._table[: self._count])

    def close(self) -> None:
        """Let go of the file."""
        if self._file is not None:
            self._file.close()


class Recorder(LeafSystem):
    """What `record` makes: it reads ports while a Simulator runs.

    .. pydrake_system::

        name: Recorder
        input_ports:
        - <one a recorded port>

    Args:
        ports: by name.
        period: between samples [s]; None: each step of the Simulator.
        file: a log that grows while the run goes on; None: none.
        diagram: the Diagram of the ports where it is built already: the ports are then read as a monitor of
            the Simulator, and this system is in no Diagram.
    """

    def __init__(
        self,
        ports: Mapping[str, OutputPort],
        *,
        period: float | None,
        file: str | Path | None,
        diagram: Diagram | None = None,
    ) -> None:
        super().__init__()
        if not ports:
            raise ValueError("there is no port to record: no vector output ports were found")
        self._ports, self._file, self._diagram = dict(ports), file, diagram
        self._period = check_positive_finite("period", period, "s") if period is not None else None
        self._rows: RowCollector | None = None
        self._read: dict[str, Callable[[Context], Array]] = {}
        if diagram is not None:
            for name, port in self._ports.items():
                self._read[name] = functools.partial(_eval_in_root, diagram, port)
            return
        for name, port in self._ports.items():
            if port.get_data_type() == PortDataType.kVectorValued:
                own = self.DeclareVectorInputPort(name, port.size())
            else:
                own = self.DeclareAbstractInputPort(name, Value(RigidTransform()))
            self._read[name] = own.Eval
        if self._period is None:
            self.DeclarePerStepPublishEvent(self._publish)
        else:
            self.DeclarePeriodicPublishEvent(self._period, 0.0, self._publish)
        self.DeclareInitializationPublishEvent(self._publish)

    def attach(self, simulator: Simulator) -> "Recorder":
        """Read the ports of a built Diagram whenever `simulator` has made a step; returns itself.

        A monitor that the Simulator has already is called too.

        Raises:
            ValueError: the recorder is of a DiagramBuilder, or of another Diagram.
        """
        if self._diagram is None or simulator.get_system() is not self._diagram:
            raise ValueError("attach is for a recorder of this Simulator's Diagram")
        before = simulator.get_monitor()

        def monitor(root: Context) -> EventStatus:
            if self._is_due(root.get_time()):
                self._sample(root)
            return before(root) if before else EventStatus.DidNothing()

        simulator.set_monitor(monitor)
        return self

    def log(self) -> RunLog:
        """The log so far.

        Raises:
            ValueError: nothing ran yet.
        """
        if self._rows is None:
            raise ValueError("nothing was recorded: no Simulator ran the Diagram yet")
        return self._rows.log()

    def save(self, path: str | Path) -> None:
        """Save the log so far; see `RunLog.save`."""
        log = self.log()
        log.save(path)

    def _is_due(self, time: float) -> bool:
        if self._period is None or self._rows is None:
            return True
        return time >= self._rows.last_time + self._period * (1.0 - 1e-9)

    def _publish(self, context: Context) -> EventStatus:
        self._sample(context)
        return EventStatus.Succeeded()

    def _sample(self, context: Context) -> None:
        if self._rows is None:
            self._start(context)
        assert self._rows is not None
        self._rows.add(
            context.get_time(), [_numbers(read(context)) for read in self._read.values()]
        )

    def _start(self, context: Context) -> None:
        """At the first sample it shows which ports can be read: the others are left out, and named."""
        columns, skipped = {}, {}
        for name, read in list(self._read.items()):
            try:
                values = _numbers(read(context))
            except (Exception, SystemExit) as error:  # an unconnected input, a demand of Drake's
                skipped[name] = str(error).split("\n")[0]
                del self._read[name]
                continue
            pose = (
                len(values) == 7 and self._ports[name].get_data_type() != PortDataType.kVectorValued
            )
            suffixes = POSE_COLUMNS if pose else range(len(values))
            columns[name] = [f"{name}_{suffix}" for suffix in suffixes]
        if not columns:
            raise ValueError(f"none of the ports can be read: {skipped}")
        names = {
            name: names_of(enum)
            for name in columns
            if self._ports[name].get_name() == "status"
            and (enum := STATUSES.get(type(self._ports[name].get_system()).__name__))
        }
        info = LogInfo(columns, names=names, versions=versions(), skipped=skipped)
        self._rows = RowCollector(info, self._file)


def record(
    where: DiagramBuilder | Diagram | Simulator,
    ports: Ports = None,
    *,
    period: float | None = None,
    file: str | Path | None = None,
) -> Recorder:
    """Record a Diagram's ports into a log; one call, before or after the Diagram is built.

        recorder = fd.record(builder)  # or fd.record(simulator)
        Simulator(builder.Build()).AdvanceTo(3.0)
        recorder.log().to_csv("run.csv")

    Args:
        where: a DiagramBuilder, to which a system is added; a Simulator, which gets a monitor; or a built
            Diagram, whose recorder `attach`es to the Simulator that runs it.
        ports: output ports, or the same by names of your own: vectors, or poses (RigidTransform, which
            become a quaternion and a position); None: every vector output port of every system there.
            Ports that cannot be read when the run starts are left out, see `log.info.skipped`.
        period: between samples [s]; None: every step of the Simulator.
        file: a log that grows while the run goes on, and can be read if the process dies.

    Returns:
        The recorder: `log()` is the log so far.

    Raises:
        ValueError: a port is no vector or pose, or of another Diagram, or there is none.
    """
    diagram = None if isinstance(where, DiagramBuilder) else where
    if isinstance(diagram, Simulator):
        diagram = diagram.get_system()
    systems = diagram.GetSystems() if isinstance(diagram, Diagram) else None
    if systems is None:
        if not isinstance(where, DiagramBuilder):
            raise ValueError(
                f"record takes a DiagramBuilder, a Diagram or a Simulator, got {where!r}"
            )
        systems = where.GetSystems()
    if ports is None:
        found = _all_vectors(systems)
    else:
        found = dict(ports) if isinstance(ports, Mapping) else _named(ports)
        for name, port in found.items():
            _check_port(name, port)
    recorder = Recorder(found, period=period, file=file, diagram=diagram)
    if isinstance(where, DiagramBuilder):
        where.AddNamedSystem(_free_name("recorder", where), recorder)
        for name, port in found.items():
            where.Connect(port, recorder.GetInputPort(name))
    elif isinstance(where, Simulator):
        recorder.attach(where)
    return recorder


def _all_vectors(systems: list) -> dict[str, OutputPort]:
    ports = [
        system.get_output_port(i) for system in systems for i in range(system.num_output_ports())
    ]
    return _named(
        port for port in ports if port.get_data_type() == PortDataType.kVectorValued and port.size()
    )


def _named(ports: Iterable[OutputPort]) -> dict[str, OutputPort]:
    return {f"{port.get_system().get_name()}/{port.get_name()}": port for port in ports}


def _check_port(name: str, port: OutputPort) -> None:
    if not isinstance(port, OutputPort):
        raise ValueError(f"ports[{name!r}] must be an output port, got {port!r}")
    if port.get_data_type() == PortDataType.kVectorValued:
        return
    if not isinstance(port.Allocate().get_value(), RigidTransform):
        raise ValueError(f"port {name} is neither a vector nor a RigidTransform")


def _free_name(name: str, builder: DiagramBuilder) -> str:
    taken = {system.get_name() for system in builder.GetSystems()}
    return next(n for n in (name, *(f"{name}_{i}" for i in range(2, 10_000))) if n not in taken)


def _eval_in_root(diagram: Diagram, port: OutputPort, root: Context) -> Array | RigidTransform:
    system = port.get_system()
    return port.Eval(root if system is diagram else system.GetMyContextFromRoot(root))


def _numbers(value: Array | RigidTransform | AbstractValue) -> Array:
    """A port's value as numbers; a pose as quaternion w, x, y, z and position."""
    if isinstance(value, RigidTransform):
        return np.concatenate([value.rotation().ToQuaternion().wxyz(), value.translation()])
    return np.asarray(value, dtype=float)
