"""The volume's slope in a step: as it is where samples are too few to tell the noise."""

from dataclasses import replace

from recorded import PLACES, recorded_at

from mukca.solver.identification.data import RobotRecordings, measure, observe
from mukca.solver.identification.inference import Objective
from mukca.solver.identification.inference.map_estimate import gauss_newton
from mukca.solver.identification.inference.start import start
from mukca.solver.identification.model import extend
from mukca.solver.identification.robot import choose_parameters


def test_few_samples_do_not_change_the_weight_of_the_volume(panda):
    """Three in each socket leave no freedom beside the arm and the centres."""
    measured = measure(recorded_at(panda, PLACES["front"], samples=3), panda)
    model = extend(panda, choose_parameters(panda))
    state = start(Objective(model, (), observe(RobotRecordings(panda, [measured]))))
    step = gauss_newton(state, ~state.at_zero)
    assert step.volume == 0  # at the nominal arm
    state = replace(state, x=state.x + 1e-5).linearised()
    assert gauss_newton(state, ~state.at_zero).volume == 1
