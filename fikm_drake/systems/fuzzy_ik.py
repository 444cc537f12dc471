"""The differential-IK block: a task error in, a joint step out."""

from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.framework import BasicVector, Context, LeafSystem

from fikm_drake.kinematics.task import Task
from fikm_drake.laws.fuzzy_mapping import FuzzyMapping
from fikm_drake.laws.steps import all_finite
from fikm_drake.systems.tool_kinematics import ToolKinematics
from fikm_drake.systems.valid_port import declare_valid_port


class FuzzyIk(LeafSystem):
    """Differential inverse kinematics by the fuzzy mapping.

    .. pydrake_system::

        name: FuzzyIk
        input_ports:
        - task_error
        - position
        - enabled
        output_ports:
        - joint_step
        - valid

    - **task_error** (m) [m]: in the world frame, amplified and filtered as the user likes.
    - **position** (n) [rad or m]: the joints.
    - **enabled** (1), optional: 0 holds the arm. The controller wires `TaskError`'s `valid` to it.
    - **joint_step** (n) [rad or m]: dθ of this cycle; zeros while an input is not finite or
      `enabled` is 0.
    - **valid** (1): 1 while every input is finite, else 0.

    Args:
        plant: a finalized plant; it is not copied.
        law: the mapping (J, dr) to a joint step; by default the paper's.
        frame: name of the tool's frame.
        task: the coordinates that count, see `Task`.

    Raises:
        ValueError: see `ToolKinematics` and `Task`.
    """

    def __init__(
        self,
        plant: MultibodyPlant,
        *,
        law: FuzzyMapping | None = None,
        frame: str = "tool",
        task: str = "position",
    ) -> None:
        super().__init__()
        self._kinematics = ToolKinematics(plant, frame, Task(task))
        self._law = law or FuzzyMapping()
        n = self._kinematics.num_joints
        self._hold = [0.0] * n
        self._error = self.DeclareVectorInputPort("task_error", self._kinematics.task.size)
        self._position = self.DeclareVectorInputPort("position", n)
        declare_valid_port(self)
        self._enabled = self.DeclareVectorInputPort("enabled", 1)
        self._scratch = self._kinematics.declare_scratch(self)
        self.DeclareVectorOutputPort(
            "joint_step",
            n,
            self._calc_step,
            prerequisites_of_calc={
                self._error.ticket(),
                self._position.ticket(),
                self._enabled.ticket(),
            },
        )

    def _calc_step(self, context: Context, output: BasicVector) -> None:
        output.set_value(self._step(context))

    def _step(self, context: Context) -> list[float]:
        if self._enabled.HasValue(context) and not self._enabled.Eval(context)[0]:
            return self._hold
        error = self._error.Eval(context).tolist()
        q = self._position.Eval(context)
        J = self._kinematics.jacobian(self._scratch.Eval(context), q)
        step = self._law.step(J, error)
        return step if all_finite(step) else self._hold
