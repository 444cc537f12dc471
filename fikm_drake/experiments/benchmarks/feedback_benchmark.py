"""A path through an inner loop, beside Drake's integrator (`fikm-drake benchmark feedback`)."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from math import pi

import numpy as np
from pydrake.common.value import AbstractValue, Value
from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.inverse_kinematics import (
    DifferentialInverseKinematicsIntegrator,
    DifferentialInverseKinematicsParameters,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import (
    BasicVector,
    Context,
    DiagramBuilder,
    DiscreteValues,
    LeafSystem,
    System,
)
from pydrake.systems.primitives import (
    ConstantValueSource,
    ConstantVectorSource,
    Multiplexer,
    VectorLogSink,
)

from fikm_drake.arrays import Array
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.diagrams.add_fuzzy_ik_controller import AddFuzzyIkController
from fikm_drake.experiments.benchmarks.benchmark_table import BenchmarkTable
from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.systems.slow_feedback import SlowFeedback

ARM, START = "iiwa14", np.array([0.3, 0.6, 0.2, -1.4, -0.2, 0.9, 0.1])
"""The arm and its joints at the start of the path [rad]."""
RATE = 200.0
"""Control cycles a second [Hz]."""
SAMPLE = 1e-3
"""Sample of the measurements [s]."""
RADIUS, TURNS = 0.08, 0.3
"""The path: a circle [m], while the tool turns there and back by this angle about z [rad]."""
STIFFNESS = (100.0, 1000.0)
"""kp of the inner loop, critically damped, of joints of unit inertia [1/s²]."""
DELAYS = (0, 5)
"""Delays of the measurement [samples of 1 ms]."""
NOISE = (1e-3,)
"""Noise of the measurement, standard deviation [rad]."""

Connect = Callable[[DiagramBuilder, MultibodyPlant, System, System], System]
"""Adds a controller for (builder, plant, source of poses, source of measured joints)."""


@dataclass(frozen=True)
class FeedbackResult:
    """One controller in front of one inner loop."""

    name: str
    """Name of `controllers`."""
    stiffness: float
    """kp of the inner loop [1/s²]."""
    delay: float
    """Delay of the measurement [s]."""
    noise: float
    """Noise of the measurement, standard deviation [rad]."""
    mean: float
    """Mean distance of the robot's tool from the path [m]."""
    largest: float
    """The largest distance [m]."""
    fastest: float
    """The fastest joint of the robot over its limit [-]."""


def controllers() -> dict[str, Connect]:
    """What is compared, all at `RATE` and inside the model's limits of position and speed."""
    return {
        "fuzzy, default, open loop": partial(_ours, pose_config()),
        "fuzzy, default, measured": partial(_ours, measured(pose_config())),
        "fuzzy, resolved rate, open loop": partial(_ours, pose_config().resolved_rate()),
        "fuzzy, resolved rate, measured": partial(_ours, measured(pose_config()).resolved_rate()),
        "fuzzy, resolved rate, slow feedback": partial(
            _slow, measured(pose_config()).resolved_rate()
        ),
        "Drake's integrator, open loop": partial(_drake, use_robot_state=False),
        "Drake's integrator, measured": partial(_drake, use_robot_state=True),
    }


def pose_config() -> FuzzyIkConfig:
    """A pose task, solved in each cycle."""
    return FuzzyIkConfig(
        task="pose", control_rate=RATE, law=FuzzyMapping(iterations=6, damping=1e-3)
    )


def measured(config: FuzzyIkConfig) -> FuzzyIkConfig:
    """The config with measured joints in the loop."""
    return replace(config, measured_position=True)


def feedback_benchmark(
    *, seconds: int = 5, progress: Callable[[float], None] | None = None
) -> list[FeedbackResult]:
    """Follow the path once in `seconds` with each controller and each inner loop.

    Args:
        seconds: duration of the path [s].
        progress: called after each run with the fraction done.

    Raises:
        ValueError: seconds is not at least 1.
    """
    if seconds < 1:
        raise ValueError(f"seconds must be at least 1, got {seconds}")
    cases = [(kp, delay, noise) for kp in STIFFNESS for delay in DELAYS for noise in NOISE]
    results = []
    for kp, delay, noise in cases:
        for name, connect in controllers().items():
            results.append(run(name, connect, seconds, kp, delay, noise))
            if progress:
                progress(len(results) / (len(cases) * len(controllers())))
    return results


def table(seconds: int, progress: Callable[[float], None]) -> BenchmarkTable:
    """The benchmark's text and rows."""
    results = feedback_benchmark(seconds=seconds, progress=progress)
    lines = [
        f"{ARM}, a circle of {RADIUS} m in {seconds} s, pose, {RATE:g} Hz, inner PD critically damped;",
        "distance of the robot's tool from the path [mm], mean / largest; fastest joint over its limit",
    ]
    for r in results:
        lines.append(
            f"  kp {r.stiffness:5g} delay {1e3 * r.delay:g} ms noise {r.noise:g} rad {r.name:32s}"
            f" {1e3 * r.mean:8.3f} / {1e3 * r.largest:8.3f}   {r.fastest:5.2f}"
        )
    return BenchmarkTable(lines, results)


def run(
    name: str, connect: Connect, seconds: float, kp: float, delay: int, noise: float
) -> FeedbackResult:
    """One controller along the path; the arguments are those of `FeedbackResult`, delay in samples."""
    arm = load_arm(ARM)
    plant = MakeDhArmPlant(arm)
    builder = DiagramBuilder()
    path = builder.AddSystem(_Path(RigidTransform(arm.forward_kinematics(START)), seconds))
    robot = builder.AddSystem(_Robot(START, kp, delay, noise))
    controller = connect(builder, plant, path, robot)
    builder.Connect(controller.get_output_port(0), robot.get_input_port())
    log = builder.AddSystem(VectorLogSink(len(START), 5 * SAMPLE))
    builder.Connect(robot.GetOutputPort("position"), log.get_input_port())
    simulator = Simulator(builder.Build())
    root = simulator.get_mutable_context()
    controller.SetPositions(controller.GetMyMutableContextFromRoot(root), START)
    simulator.AdvanceTo(seconds)
    data = log.FindLog(root)
    q, times = data.data().T, data.sample_times()
    wanted = np.array([path.pose(t).translation() for t in times])
    gap = np.linalg.norm(arm.forward_kinematics(q)[:, :3, 3] - wanted, axis=1)
    speed = np.abs(np.diff(q, axis=0) / np.diff(times)[:, None]).max(axis=0)
    fastest = float((speed / plant.GetVelocityUpperLimits()).max())
    return FeedbackResult(
        name, kp, delay * SAMPLE, noise, float(gap.mean()), float(gap.max()), fastest
    )


class _Path(LeafSystem):
    """The target: a RigidTransform on a circle, once round with a smooth start and end."""

    def __init__(self, start: RigidTransform, seconds: float) -> None:
        super().__init__()
        self._start, self._seconds = start, seconds
        self.DeclareAbstractOutputPort("pose", lambda: Value(RigidTransform()), self._calc)

    def pose(self, time: float) -> RigidTransform:
        """Where the tool shall be at a time [s]."""
        s = min(max(time / self._seconds, 0.0), 1.0)
        angle = 2.0 * pi * (s - np.sin(2.0 * pi * s) / (2.0 * pi))
        turn = RotationMatrix.MakeZRotation(TURNS * np.sin(angle))
        way = RADIUS * np.array([np.cos(angle) - 1.0, np.sin(angle), 0.5 * np.sin(angle)])
        return RigidTransform(
            turn.multiply(self._start.rotation()), self._start.translation() + way
        )

    def _calc(self, context: Context, output: AbstractValue) -> None:
        output.set_value(self.pose(context.get_time()))


class _Robot(LeafSystem):
    """Joints of unit inertia behind a critically damped PD, solved exactly for each sample.

    Output `position` (n) is where they are, `measured` (n) is late and noisy.
    """

    def __init__(self, start: Array, kp: float, delay: int, noise: float) -> None:
        super().__init__()
        n = len(start)
        self._n, self._noise = n, noise
        w = np.sqrt(kp)
        decay = np.exp(-w * SAMPLE)
        self._q = decay * (1.0 + w * SAMPLE), decay * SAMPLE
        self._v = -decay * w * w * SAMPLE, decay * (1.0 - w * SAMPLE)
        self._command = self.DeclareVectorInputPort("commanded_position", n).Eval
        state = np.concatenate([np.tile(start, delay + 1), np.zeros(n)])  # newest first, then v
        self.DeclareDiscreteState(state)
        self.DeclareVectorOutputPort("position", n, lambda c, y: y.set_value(self._state(c)[:n]))
        self.DeclareVectorOutputPort("measured", n, self._calc_measured)
        self.DeclarePeriodicDiscreteUpdateEvent(SAMPLE, 0.0, self._update)

    def _state(self, context: Context) -> Array:
        return context.get_discrete_state_vector().value()

    def _calc_measured(self, context: Context, output: BasicVector) -> None:
        n = self._n
        noise = np.random.default_rng(round(context.get_time() / SAMPLE)).normal(size=n)
        output.set_value(self._state(context)[-2 * n : -n] + self._noise * noise)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        n, state, command = self._n, self._state(context), self._command(context)
        away, v = state[:n] - command, state[-n:]
        q = command + self._q[0] * away + self._q[1] * v
        v = self._v[0] * away + self._v[1] * v
        discrete_state.set_value(np.concatenate([q, state[: -2 * n], v]))


def _ours(
    config: FuzzyIkConfig,
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    path: System,
    robot: System,
) -> System:
    controller = AddFuzzyIkController(builder, plant, config=config)
    builder.Connect(path.get_output_port(), controller.get_input_port(0))
    if config.measured_position:
        builder.Connect(
            robot.GetOutputPort("measured"), controller.GetInputPort("estimated_position")
        )
    return controller


def _slow(
    config: FuzzyIkConfig,
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    path: System,
    robot: System,
) -> System:
    controller = AddFuzzyIkController(builder, plant, config=config)
    slow = builder.AddSystem(SlowFeedback(plant.num_positions(), period=config.period))
    builder.Connect(path.get_output_port(), controller.get_input_port(0))
    builder.Connect(robot.GetOutputPort("measured"), slow.GetInputPort("measured_position"))
    command = controller.GetOutputPort("commanded_position")
    builder.Connect(command, slow.GetInputPort("commanded_position"))
    builder.Connect(slow.get_output_port(0), controller.GetInputPort("estimated_position"))
    return controller


def _drake(
    builder: DiagramBuilder,
    plant: MultibodyPlant,
    path: System,
    robot: System,
    *,
    use_robot_state: bool,
) -> System:
    """As Drake's users set it up: the plant's limits of position and speed, nothing else."""
    n = plant.num_positions()
    parameters = DifferentialInverseKinematicsParameters(n, n)
    parameters.set_time_step(1.0 / RATE)
    parameters.set_joint_position_limits(
        (plant.GetPositionLowerLimits(), plant.GetPositionUpperLimits())
    )
    parameters.set_joint_velocity_limits(
        (plant.GetVelocityLowerLimits(), plant.GetVelocityUpperLimits())
    )
    tool = plant.GetFrameByName("tool")
    controller = builder.AddSystem(
        DifferentialInverseKinematicsIntegrator(plant, tool, 1.0 / RATE, parameters)
    )
    builder.Connect(path.get_output_port(), controller.GetInputPort("X_AE_desired"))
    state = builder.AddSystem(Multiplexer([n, n]))
    rest = builder.AddSystem(ConstantVectorSource(np.zeros(n)))
    used = builder.AddSystem(ConstantValueSource(Value(use_robot_state)))
    builder.Connect(robot.GetOutputPort("measured"), state.get_input_port(0))
    builder.Connect(rest.get_output_port(), state.get_input_port(1))
    builder.Connect(state.get_output_port(), controller.GetInputPort("robot_state"))
    builder.Connect(used.get_output_port(), controller.GetInputPort("use_robot_state"))
    return controller
