"""The block that lets a controller see a robot that lags, without swinging."""

from math import exp

import numpy as np
from pydrake.systems.framework import BasicVector, Context, DiscreteValues, LeafSystem

from fikm_drake.arrays import all_finite
from fikm_drake.checks import check_counts, check_period, check_positive_finite
from fikm_drake.control.steps import low_pass
from fikm_drake.systems.valid_port import declare_valid_port


class SlowFeedback(LeafSystem):
    """Joint positions for `config.measured_position`: the command plus what the robot is off it, slowly.

    .. pydrake_system::

        name: SlowFeedback
        input_ports:
        - measured_position
        - commanded_position
        output_ports:
        - estimated_position
        - valid

    - **measured_position** (n) [rad or m]: the robot's joints.
    - **commanded_position** (n) [rad or m]: of the controller, which has this block in its loop.
    - **estimated_position** (n) [rad or m]: for the controller's port of this name. Before the first
      cycle it is the measurement, where the command then starts; while the measurement is not
      finite it is the measurement too, so that the controller says so.
    - **valid** (1): 1 while every input is finite, else 0.

    A law that works at measured joints has all that the robot is late by in its loop, and swings. One
    that works at its own command does not, but never sees a robot that droops or lags. Here the fast
    loop is closed over the command and the difference, through a first-order filter, over the
    robot: it removes what lasts (droop, lag on a path), and little of the measurement's noise.

    Args:
        num_joints: n.
        period: of the control cycle [s].
        time_constant: of the filter [s]. Not below the robot's own time constant (1/ω of a loop of
            bandwidth ω); longer is calmer, and corrects less of a lag that changes.

    Raises:
        ValueError: naming the bad value.

    Example:
        >>> from pydrake.systems.framework import DiagramBuilder
        >>> import fikm_drake as fd
        >>> plant, builder = fd.MakeDhArmPlant(fd.load_arm("arm7")), DiagramBuilder()
        >>> config = fd.FuzzyIkConfig(measured_position=True)
        >>> ik = fd.AddFuzzyIkController(builder, plant, config=config)
        >>> slow = builder.AddSystem(fd.SlowFeedback(7, period=config.period))
        >>> command = ik.GetOutputPort("commanded_position")
        >>> builder.Connect(command, slow.GetInputPort("commanded_position"))
        >>> builder.Connect(slow.get_output_port(0), ik.GetInputPort("estimated_position"))
    """

    def __init__(self, num_joints: int, *, period: float, time_constant: float = 0.1) -> None:
        super().__init__()
        check_counts(num_joints=num_joints)
        check_positive_finite("time_constant", time_constant, "s")
        self._smoothing = exp(-check_period(period) / time_constant)
        measured = self.DeclareVectorInputPort("measured_position", num_joints)
        command = self.DeclareVectorInputPort("commanded_position", num_joints)
        self._measured, self._command = measured.Eval, command.Eval
        self._started = self.DeclareDiscreteState(1)
        self._offset = self.DeclareDiscreteState(num_joints)
        self.DeclareVectorOutputPort(
            "estimated_position",
            num_joints,
            self._calc,
            prerequisites_of_calc={measured.ticket(), command.ticket(), self.xd_ticket()},
        )
        declare_valid_port(self)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _calc(self, context: Context, output: BasicVector) -> None:
        measured = self._measured(context)
        started = context.get_discrete_state(self._started).value()[0]
        if not started or not all_finite(measured):
            output.set_value(measured)
            return
        offset = context.get_discrete_state(self._offset).value()
        output.set_value(self._command(context) + offset)

    def _update(self, context: Context, discrete_state: DiscreteValues) -> None:
        measured, command = self._measured(context), self._command(context)
        if not (all_finite(measured) and all_finite(command)):
            return
        offset = discrete_state.get_mutable_value(self._offset)  # holds the present one
        offset[:] = low_pass(measured - command, np.array(offset), self._smoothing)
        discrete_state.get_mutable_value(self._started)[0] = 1.0
