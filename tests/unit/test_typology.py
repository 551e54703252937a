"""Accident types of a car that goes north, by where the two-wheeler comes from."""

import numpy as np
import pytest

from aeb_sumo.world.typology import typology

NORTH, SOUTH, EAST, WEST = np.radians([90, -90, 0, 180])


@pytest.mark.parametrize(
    ("rider", "turn", "rear_end", "expected"),
    [
        (SOUTH, "l", False, "221"),  # oncoming, the car turns left
        (SOUTH, "L", False, "221"),
        (WEST, "s", False, "321"),  # goes west: comes from the right
        (WEST, "", False, "321"),  # before the stop line
        (EAST, "s", False, "322"),
        (NORTH, "", True, "601"),
        (NORTH, "s", True, "601"),
        (NORTH, "", False, ""),  # beside each other
        (NORTH, "l", True, ""),
        (SOUTH, "s", False, ""),  # head-on
        (WEST, "l", False, ""),
        (WEST, "r", False, ""),
    ],
)
def test_types(rider, turn, rear_end, expected):
    assert typology(car=NORTH, rider=rider, turn=turn, rear_end=rear_end) == expected


@pytest.mark.parametrize("turned", [0.0, 1.0, 3.0, -2.5, 2 * np.pi])
def test_the_frame_does_not_matter(turned):
    for rider, turn, expected in ((SOUTH, "l", "221"), (WEST, "s", "321"), (EAST, "s", "322")):
        assert typology(car=NORTH + turned, rider=rider + turned, turn=turn, rear_end=False) == expected
