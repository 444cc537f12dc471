"""Laws, supervisors and the supervised differential IK under random input."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from pydrake.multibody.tree import JacobianWrtVariable
from pydrake.systems.framework import BasicVector, Context, DiagramBuilder, LeafSystem

import fikm_drake as fd
from fikm_drake.arrays import Array
from fikm_drake.experiments.fuzz.controller_fuzz import ROUNDING, Violation
from fikm_drake.experiments.fuzz.random_arm import RandomArm, random_arm
from fikm_drake.experiments.fuzz.random_case import BAD, random_law


def law_case(rng: np.random.Generator) -> Iterator[list[Violation]]:
    """A law on random Jacobians, singular ones too: finite, one by one as in a batch, linear if it is so.

    Raises:
        ValueError: the law is refused.
    """
    scale = 10.0 ** rng.uniform(-3.0, 3.0)
    law = random_law(rng, scale)
    if getattr(law, "method", "") == "direct":
        scale = 0.1
    m, n, count = int(rng.integers(1, 7)), int(rng.integers(1, 61)), 8
    J = scale * rng.normal(size=(count, m, n)) * (rng.random((count, m, n)) < 0.8)
    J[0] = 0.0
    J[1, :, rng.integers(n)] = 0.0
    J[2, rng.integers(m)] = 0.0
    J[3] = np.outer(J[3, :, 0], J[3, 0])  # of rank one
    dr = scale * 10.0 ** rng.uniform(-6.0, 2.0) * rng.normal(size=(count, m))
    dr[4] = 0.0
    if getattr(law, "method", "") == "direct":
        J, dr = np.clip(J, -1.4, 1.4), np.clip(dr, -0.1, 0.1)
    many = law(J, dr)
    for i in range(count):
        one, found = law.step(J[i], dr[i]), []
        if not (np.isfinite(one).all() and np.isfinite(many[i]).all()):
            found.append(("law not finite", f"{law}: {one}"))
        if not dr[i].any() and one.any():
            found.append(("law moves without an error", f"{law}: {one}"))
        well = i > 3 and np.linalg.cond(J[i]) < 1e3
        size = np.abs(many[i]).max() + 1e-300
        if well and not np.allclose(one, many[i], rtol=0.0, atol=1e-6 * size):
            found.append(("law differs in a batch", f"{law}: {one} and {many[i]}"))
        yield found


def command_supervisor_case(rng: np.random.Generator) -> Iterator[list[Violation]]:
    """A supervisor of commands that chatter, jump and are no numbers."""
    n = int(rng.integers(1, 61))
    supervisor = fd.CommandSupervisor(n, period=10.0 ** rng.uniform(-3.3, 0.0))
    context = supervisor.CreateDefaultContext()
    wave = 10.0 ** rng.uniform(-4.0, 3.0, n)
    often = float(rng.choice([0.0, 0.1, 0.5]))
    for k in range(int(rng.integers(10, 120))):
        command = wave * np.sin(k * rng.uniform(0.0, np.pi)) + 0.1 * wave * rng.normal(size=n)
        bad = rng.random() < often
        if bad:
            command[rng.integers(n)] = rng.choice(BAD)
        supervisor.get_input_port(0).FixValue(context, command)
        calmed, gain, valid = (
            supervisor.GetOutputPort(name).Eval(context).copy()
            for name in ("calmed_velocity", "gain", "valid")
        )
        found = []
        if not all(np.isfinite(x).all() for x in (calmed, gain)):
            found.append(("not finite", f"supervisor of commands: {calmed}"))
        elif bad:
            if valid[0] or calmed.any():
                found.append(("bad input moves", f"supervisor of commands: {calmed}"))
        elif (np.abs(calmed) > np.abs(command)).any() or (calmed * command < 0.0).any():
            found.append(("supervisor adds", f"{calmed} of {command}"))
        if ((gain <= 0.0) | (gain > 1.0)).any():
            found.append(("supervisor's gain", str(gain)))
        context.SetDiscreteState(supervisor.EvalUniquePeriodicDiscreteUpdate(context))
        if not np.isfinite(context.get_discrete_state_vector().value()).all():
            found.append(("not finite", "supervisor of commands: state"))
        yield found


def supervised_ik_case(rng: np.random.Generator) -> Iterator[list[Violation]]:
    """`AddSupervisedDifferentialIk` around a foreign differential IK that fails at times."""
    arm = random_arm(rng)
    ik = _ForeignIk(arm, rng)
    builder = DiagramBuilder()
    period = 10.0 ** rng.uniform(-3.0, -1.0)
    controller = fd.AddSupervisedDifferentialIk(builder, ik, arm.plant, period=period)
    context = controller.CreateDefaultContext()
    controller.SetPositions(context, arm.posture(rng))
    for _ in range(int(rng.integers(5, 40))):
        target = arm.scale * 10.0 ** rng.uniform(-1.0, 1.0) * rng.normal(size=3)
        if rng.random() < 0.1:
            target[rng.integers(3)] = rng.choice(BAD)
        controller.GetInputPort("target").FixValue(context, target)
        before = controller.GetOutputPort("commanded_position").Eval(context).copy()
        context.SetDiscreteState(controller.EvalUniquePeriodicDiscreteUpdate(context))
        after = controller.GetOutputPort("commanded_position").Eval(context).copy()
        found = []
        if not np.isfinite(after).all():
            found.append(("not finite", f"supervised IK: {after}"))
        if (after < arm.lower).any() or (after > arm.upper).any():
            found.append(("position limit", f"supervised IK: {after}"))
        # A target that is huge is a number to the foreign IK, and what it asks for is clipped.
        if not np.isfinite(target).all() and (np.abs(after - before) > ROUNDING).any():
            found.append(("bad input moves", f"supervised IK: {after - before}"))
        yield found


class _ForeignIk(LeafSystem):
    """Damped least squares as somebody else's block: target (3) [m] to velocities (n)."""

    def __init__(self, arm: RandomArm, rng: np.random.Generator) -> None:
        super().__init__()
        n = arm.plant.num_positions()
        position = self.DeclareVectorInputPort("position", n)
        target = self.DeclareVectorInputPort("target", 3)
        self.DeclareVectorOutputPort("commanded_velocity", n, self._calc)
        self._position, self._target, self._plant = position.Eval, target.Eval, arm.plant
        self._law = fd.DampedLeastSquares(arm.scale * 10.0 ** rng.uniform(-4.0, 0.0))
        self._context: Any = arm.plant.CreateDefaultContext()
        self._rate = 10.0 ** rng.uniform(0.0, 3.0)

    def _calc(self, context: Context, output: BasicVector) -> None:
        plant, tool = self._plant, self._plant.GetFrameByName("tool")
        plant.SetPositions(self._context, self._position(context))
        world, origin = plant.world_frame(), np.zeros((3, 1))
        J: Array = plant.CalcJacobianTranslationalVelocity(
            self._context, JacobianWrtVariable.kV, tool, origin, world, world
        )
        error = self._target(context) - tool.CalcPoseInWorld(self._context).translation()
        output.set_value(self._rate * self._law.step(J, error))
