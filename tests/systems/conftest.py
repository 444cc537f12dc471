"""A plant to control, and a way to drive a system cycle by cycle without a Simulator."""

import numpy as np
import pytest
from pydrake.multibody.plant import MultibodyPlant

import fikm_drake as fd


def make_plant(*names):
    """A finalized plant with these arms."""
    plant = MultibodyPlant(0.0)
    for name in names:
        fd.AddDhArm(plant, fd.load_arm(name))
    plant.Finalize()
    return plant


@pytest.fixture(scope="session")
def arm7():
    return fd.load_arm("arm7")


@pytest.fixture(scope="session")
def plant():
    """A plant with arm7."""
    return make_plant("arm7")


@pytest.fixture(scope="session")
def plant_with():
    return make_plant


def port_sizes(system):
    """Name and size of the inputs and of the outputs, in order."""
    inputs = [system.get_input_port(i) for i in range(system.num_input_ports())]
    outputs = [system.get_output_port(i) for i in range(system.num_output_ports())]
    return tuple({port.get_name(): port.size() for port in ports} for ports in (inputs, outputs))


@pytest.fixture(scope="session")
def ports():
    return port_sizes


class Driver:
    """A system with a Context of its own, driven cycle by cycle."""

    def __init__(self, system, context=None):
        self.system = system
        self.context = system.CreateDefaultContext() if context is None else context
        self.outputs = list(port_sizes(system)[1])

    def feed(self, **inputs):
        for name, value in inputs.items():
            self.system.GetInputPort(name).FixValue(self.context, value)
        return self

    def __getitem__(self, output):
        return self.system.GetOutputPort(output).Eval(self.context).copy()

    def read(self):
        return {name: self[name] for name in self.outputs}

    def state(self):
        values = self.context.get_discrete_state()
        return [values.value(i).copy() for i in range(values.num_groups())]

    def update(self):
        """Let the cycle's end come."""
        after = self.system.EvalUniquePeriodicDiscreteUpdate(self.context)
        self.context.SetDiscreteState(after)

    def cycle(self, **inputs):
        """One cycle: the outputs that these inputs give, then the update."""
        outputs = self.feed(**inputs).read()
        if self.context.num_discrete_state_groups():
            self.update()
        return outputs


@pytest.fixture(scope="session")
def drive():
    return Driver


@pytest.fixture(scope="session")
def equal():
    """Compares two lists of what `Driver.cycle` returns, to the last bit."""

    def check(first, second):
        assert len(first) == len(second)
        for a, b in zip(first, second):
            assert a.keys() == b.keys()
            for name in a:
                np.testing.assert_array_equal(a[name], b[name], err_msg=name)

    return check
