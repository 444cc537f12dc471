"""Plants, controllers, and a way to run a controller cycle by cycle on given inputs."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.common.value import Value
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd


@pytest.fixture(scope="session")
def plant_with():
    """Makes a finalized plant with these arms, each named or a DhArm."""

    def make(*arms):
        plant = MultibodyPlant(0.0)
        for arm in arms:
            fd.AddDhArm(plant, fd.load_arm(arm) if isinstance(arm, str) else arm)
        plant.Finalize()
        return plant

    return make


@pytest.fixture(scope="session")
def plant(plant_with):
    """A plant with arm7."""
    return plant_with("arm7")


@pytest.fixture(params=[False, True], ids=["diagram", "fused"])
def fused(request):
    return request.param


@pytest.fixture(scope="session")
def ports():
    """Name and size of the inputs and of the outputs, in order."""

    def of(system):
        inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
        outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
        return tuple({port.get_name(): port.size() for port in each} for each in (inputs, outputs))

    return of


@pytest.fixture(scope="session")
def run(ports):
    """run(plant, config, start, desired (N,m) or N poses) -> outputs of every cycle, as arrays.

    `measure(k, commanded)` gives the measured joints where the config wants them; `only` names the
    outputs that are wanted, if not all; `checker` sees obstacles. The outputs are read before the cycle's
    update; `after` is the command after the last.
    """

    def run(plant, config, start, desired, measure=None, only=None, checker=None):
        controller = fd.MakeFuzzyIkController(plant, config=config, collision_checker=checker)
        context = controller.CreateDefaultContext()
        controller.SetPositions(context, start)
        command = controller.GetOutputPort("commanded_position")
        series = {name: [] for name in only or ports(controller)[1]}
        for k, target in enumerate(desired):
            target = Value(target) if isinstance(target, RigidTransform) else target
            controller.get_input_port(0).FixValue(context, target)
            if measure is not None:
                measured = measure(k, command.Eval(context).copy())
                controller.GetInputPort("estimated_position").FixValue(context, measured)
            for name, values in series.items():
                values.append(controller.GetOutputPort(name).Eval(context).copy())
            after = controller.EvalUniquePeriodicDiscreteUpdate(context)
            context.SetDiscreteState(after)
        result = {name: np.array(values) for name, values in series.items()}
        return result | {"after": command.Eval(context).copy()}

    return run


@pytest.fixture(scope="session")
def scenario_inputs():
    """scenario_inputs(name) -> plant's arm, config, start and desired (N,m) of a scenario."""

    def inputs(name, **changes):
        scenario = fd.load_scenario(name)
        desired = scenario.targets()
        config = replace(scenario.controller_config(), **changes)
        return scenario.load_arm(), config, scenario.start(), desired

    return inputs
