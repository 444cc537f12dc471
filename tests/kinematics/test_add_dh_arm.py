"""Plants of Denavit-Hartenberg arms: bad time steps are refused before Drake ends the process."""

from math import inf, nan

import pytest

from fikm_drake.kinematics.add_dh_arm import MakeDhArmPlant
from fikm_drake.kinematics.load_arm import load_arm


@pytest.mark.parametrize("time_step", [-1e-3, nan, inf, None, "1 ms"])
def test_bad_time_step_is_named(time_step):
    with pytest.raises(ValueError) as error:
        MakeDhArmPlant(load_arm("planar2"), time_step=time_step)
    assert "time_step" in str(error.value) and repr(time_step) in str(error.value)


@pytest.mark.parametrize("time_step", [0.0, 1e-3])
def test_the_plant_holds_the_arm_only(time_step):
    plant = MakeDhArmPlant(load_arm("planar2"), time_step=time_step)
    assert plant.is_finalized() and plant.num_positions() == 2 and plant.num_actuators() == 2
    assert plant.time_step() == time_step
