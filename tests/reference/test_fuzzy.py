"""The control surfaces against inference by scikit-fuzzy itself."""

import warnings

import numpy as np
import pytest
import skfuzzy
from skfuzzy import control

from aeb_sumo.strategies import zhao2025, zheng2020


def simulation(base):
    """`skfuzzy.control` on the whole rule base."""
    inputs = (
        control.Antecedent(np.linspace(*base.x_range, 2001), "x"),
        control.Antecedent(np.linspace(*base.y_range, 2001), "y"),
    )
    output = control.Consequent(base.universe(), "z")
    for variable, sets in zip(inputs, (base.x_sets, base.y_sets), strict=True):
        for k, (centre, sigma) in enumerate(sets):
            variable[str(k)] = skfuzzy.gaussmf(variable.universe, centre, sigma)
    for k, memberships in enumerate(base.output_sets()):
        output[str(k)] = memberships
    rules = [
        control.Rule(inputs[0][str(i)] & inputs[1][str(j)], output[str(k)]) for (i, j), k in np.ndenumerate(base.rules)
    ]
    return control.ControlSystemSimulation(control.ControlSystem(rules))


def infer(system, x, y):
    """Building the system takes seconds, so all points may go in at once."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        system.input["x"], system.input["y"] = x, y
        system.compute()
    return system.output["z"]


@pytest.mark.parametrize("module", [zhao2025, zheng2020])
def test_the_surface_is_the_inference(module):
    base = module.rule_base()
    system = simulation(base)
    for seed in (1, 2, 3):
        rng = np.random.default_rng(seed)
        x, y = rng.uniform(*base.x_range, 1000), rng.uniform(*base.y_range, 1000)
        error = np.abs(module._surface()(x, y) - infer(system, x, y))
        assert error.max() < 0.02


def test_inputs_saturate():
    surface = zhao2025._surface()
    assert surface([150.0], [80.0])[0] == surface([100.0], [60.0])[0]
    assert surface([-5.0], [-1.0])[0] == surface([0.0], [0.0])[0]
