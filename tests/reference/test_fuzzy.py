"""The control surface against inference by scikit-fuzzy itself."""

import warnings

import numpy as np
import skfuzzy
from skfuzzy import control

from aeb_sumo.strategies.zhao2025 import _surface, rule_base


def exact(base, x, y):
    """`skfuzzy.control` on the whole rule base: building it takes seconds, so all points go in at once."""
    inputs = (
        control.Antecedent(np.linspace(*base.x_range, 2001), "x"),
        control.Antecedent(np.linspace(*base.y_range, 2001), "y"),
    )
    output = control.Consequent(base.universe(), "z")
    for variable, sets in zip(inputs, (base.x_sets, base.y_sets), strict=True):
        for k, (centre, sigma) in enumerate(sets):
            variable[str(k)] = skfuzzy.gaussmf(variable.universe, centre, sigma)
    for k, (centre, width, slope) in enumerate(base.z_sets):
        output[str(k)] = skfuzzy.gbellmf(output.universe, width, slope, centre)
    rules = [
        control.Rule(inputs[0][str(i)] & inputs[1][str(j)], output[str(k)]) for (i, j), k in np.ndenumerate(base.rules)
    ]
    simulation = control.ControlSystemSimulation(control.ControlSystem(rules))
    simulation.input["x"], simulation.input["y"] = x, y
    simulation.compute()
    return simulation.output["z"]


def test_the_surface_is_the_inference():
    rng = np.random.default_rng(1)
    x, y = rng.uniform(0, 100, 300), rng.uniform(0, 60, 300)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        wanted = exact(rule_base(), x, y)
    error = np.abs(_surface()(x, y) - wanted)
    assert error.max() < 0.03
    assert np.percentile(error, 99) < 0.02


def test_inputs_saturate():
    surface = _surface()
    assert surface([150.0], [80.0])[0] == surface([100.0], [60.0])[0]
    assert surface([-5.0], [-1.0])[0] == surface([0.0], [0.0])[0]
