"""Whose warning it is that reaches a driver."""

import pytest

from aeb_sumo.drivers.encounters import Warned
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.motorists import Motorists
from aeb_sumo.world.leads import Leads
from aeb_sumo.world.observe import Traffic

DT = 0.1
HEARD = 10.0 + DT  # of a warning in the step that begins at 10 s


@pytest.fixture
def motorists():
    """One driver who has been warned at 10 s, and hears it 2 s later."""
    traffic = Traffic(DT)
    traffic.slot["ego"] = traffic.admit("ego", "passenger", "car", length=4.6, width=1.8)
    warned = Warned(responds=1.0, delay_mean=2.0, delay_sd=0.0)
    result = Motorists(traffic, Leads(traffic, cycle=DT, horizon=5.0), Profile(name="test", warned=warned), 1)
    result.hear(HEARD, [("ego", "lead")])
    return result


@pytest.mark.parametrize(
    ("span", "his"), [((10.0, 10.0), True), ((9.0, 10.4), True), ((8.0, 9.8), False), ((11.2, 11.2), False)]
)
def test_a_warning_is_that_of_the_intervention_that_gave_it(motorists, span, his):
    assert motorists.alerted(0, span, by=HEARD + 2.0) == his
    motorists.unwarned(0, span)
    assert motorists.alerted(0, (10.0, 10.0), by=HEARD + 2.0) != his


def test_it_reaches_him_when_it_is_due(motorists):
    assert not motorists.alerted(0, (10.0, 10.0), by=HEARD + 1.9)


def test_the_same_warning_again_is_no_other(motorists):
    motorists.hear(HEARD + 1.5, [("ego", "lead")])
    assert motorists.alerted(0, (10.0, 10.0), by=HEARD + 2.0)


def test_a_warning_of_another_that_would_come_later_does_not_delay_it(motorists):
    motorists.hear(HEARD + 0.5, [("ego", "other")])
    assert motorists.alerted(0, (10.0, 10.0), by=HEARD + 2.0)


def test_the_only_warning_can_be_taken_back_whosever_it_is(motorists):
    motorists.unwarned(0)
    assert not motorists.alerted(0, (10.0, 10.0), by=100.0)
