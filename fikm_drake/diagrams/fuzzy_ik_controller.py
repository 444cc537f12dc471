"""The fuzzy IK controller as a Diagram of blocks (Xu & Nechyba 1993, figure 1)."""

import dataclasses

from numpy.typing import ArrayLike
from pydrake.multibody.plant import MultibodyPlant
from pydrake.planning import CollisionChecker
from pydrake.systems.framework import Context, Diagram, DiagramBuilder, InputPort, System

from fikm_drake.control.clearance import make_clearance
from fikm_drake.control.cycle import make_law, make_limits
from fikm_drake.control.fuzzy_ik_config import FuzzyIkConfig
from fikm_drake.kinematics.task_kinematics import TaskKinematics
from fikm_drake.kinematics.tasks import as_task
from fikm_drake.laws import LawLike
from fikm_drake.laws.law import takes_damping
from fikm_drake.systems.clearance_filter import ClearanceFilter
from fikm_drake.systems.command_smoother import CommandSmoother
from fikm_drake.systems.differential_ik import DifferentialIk
from fikm_drake.systems.gain_supervisor import GainSupervisor
from fikm_drake.systems.guard_block import GuardBlock
from fikm_drake.systems.joint_integrator import JointIntegrator
from fikm_drake.systems.low_pass_filter import LowPassFilter
from fikm_drake.systems.null_space_filter import NullSpaceFilter
from fikm_drake.systems.restart_planner import RestartPlanner
from fikm_drake.systems.status_monitor import StatusMonitor
from fikm_drake.systems.task_error import TaskError
from fikm_drake.systems.variable_gain import VariableGain


class FuzzyIkController(Diagram):
    """Moves a tool to a desired position by fuzzy inverse kinematics.

    .. pydrake_system::

        name: FuzzyIkController
        input_ports:
        - desired_position
        - estimated_position
        output_ports:
        - commanded_position
        - commanded_velocity
        - joint_step
        - task_error
        - gain
        - oscillating
        - oscillating_joint
        - status

    - **desired_position** (m) [m]: target of the tool's origin, in the world frame. Other tasks have
      another port in its place: **desired_pose**, a RigidTransform X_WE, for those with orientation,
      **desired_pointing** (6) for `pointing`, or whatever a task of one's own declares.
    - **estimated_position** (n) [rad or m]: the robot's joints. The command starts there, in the
      initialization event, and with `config.measured_position` the law works there. May stay
      unconnected without that: then set the start by `SetPositions`.
    - **commanded_position** (n) [rad or m]: from the state; with `config.jerk_limits` the mean of the last
      commands, while `task_error` is of the newest.
    - **commanded_velocity** (n) [rad/s or m/s]: the last change of the command over the period.
    - **joint_step** (n) [rad or m]: dθ of this cycle, what the guard lets through.
    - **task_error** (m) [m]: desired minus actual, in the world frame; see `TaskError`.
    - **gain** (1) [-]: K of Table I, before its filter.
    - **oscillating** (1): 1 while a joint oscillates, else 0.
    - **oscillating_joint** (1): the joint that oscillates, or did before the arm was calmed; −1: none.
    - **status** (1): a `ControllerStatus`.
    - **null_space_motion** (n) [rad/s or m/s], with `config.null_space_motion`: what the joints should do
      beside the task, as of `NullSpaceMotion`; what the task leaves free of it is done.
    - with a collision checker, **obstacle_position**, **clearance** and **blocking_bodies**: as of
      `ClearanceFilter`; `BlockingPair(context)` gives the bodies' names.

    While an input is not finite the status says so, the task error reads zero and the command
    holds, with limits of acceleration after braking; the filters meanwhile decay to rest. While only the
    target is lost, obstacles that come near are evaded as ever.

    Args:
        plant: a finalized plant; it is not copied.
        config: see `FuzzyIkConfig`.
        law: another law than the config's.
        task: another task than the config's, an object.
        collision_checker: what the arm keeps clear of, such as of `MakeCollisionChecker`; its plant has
            joints of the same names. None: obstacles are not seen.

    Raises:
        ValueError: naming the bad value and the valid ones.

    Example:
        >>> import fikm_drake as fd
        >>> plant = fd.MakeDhArmPlant(fd.load_arm("arm7"))
        >>> fd.FuzzyIkController(plant, config=fd.FuzzyIkConfig()).num_output_ports()
        7
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        config: FuzzyIkConfig,
        law: LawLike | None = None,
        task: TaskKinematics | None = None,
        collision_checker: CollisionChecker | None = None,
    ) -> None:
        super().__init__()
        config.validate()
        config = dataclasses.replace(config)
        task = as_task(plant, config.frame, task or config.task, config.characteristic_length)
        law, arm = make_law(task, config, law), task.arm
        n, m = arm.num_joints, task.size
        period, limits = config.period, make_limits(config, arm)
        limit = config.error_limit

        builder = DiagramBuilder()
        add = builder.AddNamedSystem
        error = add("task_error", TaskError(plant, task=task))
        supervisor = add(
            "gain_supervisor",
            GainSupervisor(
                m,
                n,
                period=period,
                config=config.supervisor,
                task=task,
                error_limit=limit,
                tolerance=config.tolerance,
                damped=takes_damping(law),
            ),
        )
        gain_filter = add(
            "gain_filter",
            LowPassFilter(
                1,
                period=period,
                smoothing=config.gain_smoothing,
                initial_value=config.supervisor.initial_gain,
            ),
        )
        gain = add("variable_gain", VariableGain(m, limit=limit))
        error_filter = add(
            "error_filter", LowPassFilter(m, period=period, smoothing=config.error_smoothing)
        )
        ik = add(
            "differential_ik",
            DifferentialIk(
                plant,
                law=law,
                task=task,
                guarded=True,
                damped=takes_damping(law),
                max_joint_step=config.max_joint_step,
                limit_margin=config.limit_margin,
                limit_retreat=config.limit_retreat,
                posture_gain=config.posture_rate * period,
                nominal_position=config.nominal_position,
                singularity_nudge=config.singularity_nudge,
                limits=limits,
                yields=collision_checker is not None,
            ),
        )
        guard = add("guard", GuardBlock(limits, max_joint_step=config.max_joint_step))
        integrator = add(
            "joint_integrator",
            JointIntegrator(
                arm.lower,
                arm.upper,
                period=period,
                initial_position=arm.default_position,
                following_distance=config.following(arm),
            ),
        )
        smoothing = config.smoothing(arm, among_obstacles=collision_checker is not None)
        sent: System = integrator  # whose position goes out
        if smoothing:
            sent = add(
                "command_smoother",
                CommandSmoother(smoothing, period=period, initial_position=arm.default_position),
            )
        status = add(
            "status_monitor",
            StatusMonitor(
                m,
                tolerance=config.tolerance,
                restart_search=config.restart_search,
                blocked=collision_checker is not None,
                smoothed=smoothing is not None and not config.measured_position,
            ),
        )
        self._placed = list(dict.fromkeys((integrator, sent)))

        def wire(source: System, output: str, target: System, port: str) -> None:
            builder.Connect(source.GetOutputPort(output), target.GetInputPort(port))

        wire(error, "task_error", supervisor, "task_error")
        wire(error, "task_error", gain, "task_error")
        wire(supervisor, "gain", gain_filter, "u0")
        wire(gain_filter, "y0", gain, "gain")
        wire(gain, "amplified_error", error_filter, "u0")
        wire(error_filter, "y0", ik, "task_error")
        if takes_damping(law):
            wire(supervisor, "damping", ik, "damping")
        source: System = ik  # of the joint step
        seers: list[System] = [error, ik]  # blocks that need the joints
        exported: set[str] = set()
        extra: list[InputPort] = []  # to export after those that are always there
        if config.null_space_motion:
            source = add("null_space_filter", NullSpaceFilter(task, period=period))
            wire(ik, "joint_step", source, "law_step")
            wire(error, "valid", source, "valid")
            extra.append(source.GetInputPort("null_space_motion"))
            seers.append(source)
        clearance = None
        if collision_checker is not None:
            clearance = make_clearance(arm, collision_checker, config.clearance, period)
        if config.restart_search:
            planner = add(
                "restart_planner",
                RestartPlanner(
                    plant,
                    task=task,
                    period=period,
                    tolerance=config.tolerance,
                    speed=config.restart_speed,
                    limits=limits,
                    clearance=clearance,
                ),
            )
            wire(source, "joint_step", planner, "law_step")
            wire(planner, "restart_search", status, "restart_search")
            source = planner
            seers.append(planner)
        self._clear = None
        if clearance is not None:
            clear = add("clearance_filter", ClearanceFilter(clearance, task=task, limits=limits))
            wire(source, "joint_step", clear, "asked_step")
            wire(integrator, "position", clear, "command")
            wire(integrator, "velocity", clear, "command_velocity")
            wire(clear, "blocked", status, "blocked")
            wire(clear, "obstacles_near", ik, "obstacles_near")
            self._clear = source = clear
            seers.append(clear)
            if clear.HasInputPort("obstacle_position"):
                extra.append(clear.GetInputPort("obstacle_position"))
                if config.restart_search:
                    extra.append(planner.GetInputPort("obstacle_position"))
        wire(source, "joint_step", guard, "joint_step")
        wire(ik, "limited", guard, "limited")
        for block in (ik, guard):
            wire(integrator, "position", block, "command")
        wire(integrator, "velocity", guard, "command_velocity")
        wire(guard, "joint_step", supervisor, "joint_step")
        if config.measured_position:
            wire(integrator, "deviation", supervisor, "deviation")
        wire(guard, "joint_step", integrator, "joint_step")
        wire(error, "task_error", status, "task_error")
        wire(error, "valid", status, "valid")
        wire(guard, "limited", status, "limited")
        wire(supervisor, "oscillating", status, "oscillating")
        wire(supervisor, "calmed", status, "calmed")
        wire(integrator, "following", status, "following")

        desired = error.get_input_port(0)  # desired_position or desired_pose
        builder.ExportInput(desired, desired.get_name())
        builder.ConnectInput(desired.get_name(), ik.GetInputPort("guard"))
        builder.ConnectInput(desired.get_name(), supervisor.GetInputPort("target"))
        if config.restart_search:
            builder.ConnectInput(desired.get_name(), planner.GetInputPort(desired.get_name()))
        builder.ExportInput(integrator.GetInputPort("estimated_position"), "estimated_position")
        if smoothing:
            wire(integrator, "position", sent, "command")
            builder.ConnectInput("estimated_position", sent.GetInputPort("estimated_position"))
            if not config.measured_position:
                sent_error = add("sent_error", TaskError(plant, task=task))
                builder.ConnectInput(desired.get_name(), sent_error.get_input_port(0))
                wire(sent, "position", sent_error, "position")
                wire(sent_error, "task_error", status, "sent_error")
        for port in extra:
            if port.get_name() in exported:
                builder.ConnectInput(port.get_name(), port)
            else:
                builder.ExportInput(port, port.get_name())
                exported.add(port.get_name())
        for block in seers:
            if not config.measured_position:
                wire(integrator, "position", block, "position")
            else:
                builder.ConnectInput("estimated_position", block.GetInputPort("position"))
        for block, port, name in (
            (sent, "position", "commanded_position"),
            (sent, "velocity", "commanded_velocity"),
            (guard, "joint_step", "joint_step"),
            (error, "task_error", "task_error"),
            (supervisor, "gain", "gain"),
            (supervisor, "oscillating", "oscillating"),
            (supervisor, "oscillating_joint", "oscillating_joint"),
            (status, "status", "status"),
        ):
            builder.ExportOutput(block.GetOutputPort(port), name)
        if self._clear:
            for name in ("clearance", "blocking_bodies"):
                builder.ExportOutput(self._clear.GetOutputPort(name), name)
        builder.BuildInto(self)

    def BlockingPair(self, context: Context) -> tuple[str, str]:
        """Scoped names of the bodies that push most in this Diagram's context; empty for none."""
        if self._clear is None:
            return "", ""
        return self._clear.BlockingPair(self.GetSubsystemContext(self._clear, context))

    def SetPositions(self, context: Context, position: ArrayLike) -> None:
        """Set the commanded joint position (n,) [rad or m] in this controller's context, at rest.

        Raises:
            ValueError: naming the bad value.
            RuntimeError: the context is another system's.
        """
        for block in self._placed:
            block.SetPositions(self.GetMutableSubsystemContext(block, context), position)
