"""Intersections from parameters: what they are, where everything lies, and whether they can be built.

The types of Yan et al. 2025 (`w0`, `w1`, `w2`, `w2t`, `b2`) and a user's own are made here; `sumo_nets.plain` writes
them as plain XML. The road users drive on the right. Seen from the middle of the road to its edge, every arm has, each
way: half the median, `lanes` car lanes, the green strip, the bicycle lane. Of several car lanes the innermost is for
left turns only and the outermost for right turns too.
"""

import math
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sumo_nets.turning_path import TurningPath, turning_path

__all__ = ["AGAINST", "ARMS", "LEFT", "OPPOSITE", "RIGHT", "Intersection"]

ARMS = {"s": (0, 1), "w": (1, 0), "n": (0, -1), "e": (-1, 0)}
"""Arm -> heading of who comes from it."""
LEFT = {"s": "w", "e": "s", "n": "e", "w": "n"}
"""Arm -> where a left turn leads."""
RIGHT = {to: arm for arm, to in LEFT.items()}
"""Arm -> where a right turn leads."""
OPPOSITE = {"s": "n", "n": "s", "e": "w", "w": "e"}
"""Arm -> where straight on leads."""

AGAINST = 1.0
"""Width of the edge of the road that riders against the lane keep to [m], our assumption: they pass the others."""

_CORNER = 2.0  # m, our assumption: from a stop line at least to the edge of the crossing road
_APART = 2.4  # m, our assumption: between the paths of opposing left turns, a car's width and some
_CAR = 1.82  # m, width of a car, from another source (seeds.md 4.4), for Yan's car
_CLEAR = 0.3  # m, our assumption: of the oncoming lane, for a car that waits to turn left
_WAITING = 4.0  # m, our assumption: each of the two sides of a waiting area
_BUILDING = 40.0  # m, our assumption: how far buildings reach along the arms
_CHOICES = {"bike_left": ("two_stage", "one_stage", "none")}


def _within(default: float, low: float, high: float) -> Any:
    return field(default=default, metadata={"range": (low, high)})


@dataclass(frozen=True, kw_only=True)
class Intersection:
    """An intersection; the defaults are those of type W0.

    Attributes:
        arms: of "nesw" those that there are, four or three (a T); our assumption.
        lanes: for cars, per direction; our assumption.
        lane_width: of a car lane [m]; 2.8, our assumption: with the rest it gives the 4.8 m of Table 1.
        bike_lane: width of the bicycle lane [m]; 1.2, our assumption, the same.
        median: width of the strip between the directions [m].
        separation: width of the green strip between the car lanes and the bicycle lane [m].
        turn_radius: of the arc of a left turn [m]; 16 printed (Table 3, 20 km/h). The rest of the path follows from it.
        arm_length: from the centre to the end of an arm [m], our assumption.
        speed_limit: [m/s]; 50 km/h, our assumption.
        signal: traffic lights; without, the road that goes through has priority (of two, that from north to south).
        green: of each of the two phases [s], our assumption; left turns are permissive.
        bike_left: riders turn left in two stages (straight on, then with the crossing road), in one, or not at all.
        contraflow: riders go straight on against their lane too, along the edge of the road.
        setback: of the buildings at the corners, from the edge of the road [m]; 0 for no buildings.
    """

    arms: str = "nesw"
    lanes: int = _within(1, 1, 4)
    lane_width: float = _within(2.8, 2.5, 4.0)
    bike_lane: float = _within(1.2, 0.8, 5.0)
    median: float = _within(0.0, 0.0, 30.0)
    separation: float = _within(0.0, 0.0, 10.0)
    turn_radius: float = _within(16.0, 10.0, 29.0)
    arm_length: float = _within(250.0, 60.0, 2000.0)
    speed_limit: float = _within(13.89, 2.0, 33.4)
    signal: bool = True
    green: float = _within(30.0, 5.0, 300.0)
    bike_left: str = "two_stage"
    contraflow: bool = False
    setback: float = _within(0.0, 0.0, 100.0)

    def __post_init__(self) -> None:
        """Raises `ValueError` with one line for a parameter out of range or geometry that does not fit."""
        for item in fields(self):
            value = getattr(self, item.name)
            low, high = item.metadata.get("range", (-math.inf, math.inf))
            if item.metadata and not low <= value <= high:
                raise ValueError(f"intersection: {item.name} must be within {low:g} .. {high:g}, not {value:g}")
            if value not in _CHOICES.get(item.name, (value,)):
                allowed = ", ".join(_CHOICES[item.name])
                raise ValueError(f"intersection: {item.name} must be one of {allowed}, not {value!r}")
        if len(self.arms) not in (3, 4) or len(set(self.arms)) != len(self.arms) or not set(self.arms) <= set(ARMS):
            raise ValueError(f'intersection: arms must be three or four of "nesw", each once, not {self.arms!r}')
        self._check_geometry()

    def _check_geometry(self) -> None:
        about = (
            f"lanes {self.lanes}, lane_width {self.lane_width:g}, median {self.median:g}, "
            f"separation {self.separation:g} and bike_lane {self.bike_lane:g} m"
        )
        if self.stop < self.half_width + _CORNER:
            raise ValueError(
                f"intersection: turn_radius {self.turn_radius:g} m does not fit: with {about} the stop line lies "
                f"{self.stop:.1f} m from the centre, and must be {self.half_width + _CORNER:.1f} m or more"
            )
        forward, left = self._turn
        nearest = int(np.argmin(np.hypot(forward - self.stop, left - self.inner)))
        # The opposing turn is this one mirrored at the centre, which it must leave on its right.
        before = self.stop - forward[nearest]
        apart = math.copysign(2 * math.hypot(before, left[nearest] - self.inner), before)
        if apart < _APART:
            raise ValueError(
                f"intersection: median {self.median:g} m does not fit turn_radius {self.turn_radius:g} m: opposing "
                f"left turns pass each other at {apart:.1f} m, and must at {_APART:g} m or more"
            )
        if self.arm_length < self.stop + 30.0:
            raise ValueError(
                f"intersection: arm_length must be {self.stop + 30:.0f} m or more with turn_radius "
                f"{self.turn_radius:g} m, not {self.arm_length:g}"
            )
        if self.setback and self.setback + self.half_width > _BUILDING:
            raise ValueError(
                f"intersection: setback must be {_BUILDING - self.half_width:.0f} m or less, not {self.setback:g}"
            )

    @property
    def offset(self) -> float:
        """Lateral offset from the path of a car that turns left to that of the oncoming rider [m].

        Half the own lane, the median, the oncoming lanes, the green strip, half the bicycle lane: "average width" of
        Yan et al. 2025, Table 1, as read in seeds.md 4.1.
        """
        return self.inner + self.bike

    @property
    def inner(self) -> float:
        """From the middle of the road to that of the innermost car lane [m]."""
        return self.lane(self.lanes)

    @property
    def bike(self) -> float:
        """From the middle of the road to that of the bicycle lane [m]."""
        return self.median / 2 + self.lanes * self.lane_width + self.separation + self.bike_lane / 2

    @property
    def against(self) -> float:
        """From the middle of the road to where riders against the lane ride, beyond the bicycle lane [m]."""
        return self.bike + (self.bike_lane + AGAINST) / 2

    @property
    def half_width(self) -> float:
        """From the middle of the road to its edge [m]."""
        return self.bike + self.bike_lane / 2 + AGAINST * self.contraflow

    def lane(self, index: int) -> float:
        """From the middle of the road to that of a lane [m]: 0 is the bicycle lane, 1 the outermost for cars."""
        return self.bike if index == 0 else self.median / 2 + (self.lanes - index + 0.5) * self.lane_width

    @cached_property
    def stop(self) -> float:
        """From the centre to the stop lines [m]: there the left turn from innermost to innermost lane begins."""
        return round(self.turn[0].reach - self.inner, 2)

    @cached_property
    def turn(self) -> tuple[TurningPath, float]:
        """Path and speed [m/s] of a car that turns left."""
        return turning_path(self.turn_radius)

    @cached_property
    def _turn(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        points = self.turn[0].points(0.1)
        return points[:, 0], points[:, 1]

    def waits_at(self, arm: str) -> float:
        """How far into its turn a car from an arm waits for a gap [m].

        Its left front corner is clear of the oncoming lane; without signals, from the road that has to yield, its front
        of the road that has priority.
        """
        forward, left = self._turn
        heading = np.arctan2(np.gradient(left), np.gradient(forward))
        enters = left + _CAR / 2 * np.cos(heading) > self.lane_width / 2 + self.median - _CLEAR
        if not self.signal and arm not in self.main:
            riders = self._waiting_corner if self.bike_left == "two_stage" else 0.0  # on their way to wait
            enters |= forward > self.stop - max(self.half_width, riders + 0.5) - _CLEAR
        # Beyond a third of its turn a car stands in the way of others.
        return round(0.1 * min(int(np.argmax(enters)), len(left) // 3), 1)

    @property
    def main(self) -> str:
        """The axis that goes through and has priority: "ns" or "ew"."""
        return "ns" if {"n", "s"} <= set(self.arms) else "ew"

    def movements(self, arm: str) -> dict[str, str]:
        """Turn (`left`, `straight`, `right`) -> arm that it leads to, for those that are there."""
        turns = {"left": LEFT[arm], "straight": OPPOSITE[arm], "right": RIGHT[arm]}
        return {turn: to for turn, to in turns.items() if to in self.arms}

    def car_lanes(self, arm: str, turn: str) -> list[int]:
        """Lanes of an arm, 1 the outermost, from which cars make a turn; the lane behind it has the same number."""
        there = self.movements(arm)
        if turn == "left":
            return [self.lanes]
        alone = self.lanes - 1 if "left" in there and self.lanes > 1 else self.lanes
        if turn == "right" and "straight" in there:
            return [1]
        return list(range(1, alone + 1))

    def right_turn(self, lane: int) -> list[tuple[float, float]]:
        """Path of a car that turns right, an arc from stop line to stop line, as points for `at` [m]."""
        aside = self.lane(lane)
        radius = self.stop - aside
        bends = [math.radians(9 * k) for k in range(11)]
        return [(self.stop - radius * math.sin(b), self.stop - radius * math.cos(b)) for b in bends]

    def waiting_area(self, arm: str) -> tuple[tuple[float, float], ...]:
        """Where riders from an arm wait to turn left in two stages, as points for `at`; none where they do not.

        Where the road ends nobody comes towards them, and they turn in one.

        Straight ahead, in the corner outside of those who turn right out of the crossing road, they come in at the
        first point, turn at the second and wait at the third to go on with the crossing road.
        """
        if self.bike_left != "two_stage" or not {"left", "straight"} <= set(self.movements(arm)):
            return ()
        x = y = self._waiting_corner
        if RIGHT[arm] not in self.arms:  # nobody comes out there: at the edge of the road
            x, y = self.half_width + _WAITING, self.bike
        return (_WAITING - y, x), (-y, x), (-y, x - _WAITING)

    @property
    def _waiting_corner(self) -> float:
        """Outer coordinates of the waiting areas [m]: clear of the roads and of the outermost right turn."""
        radius = self.stop - self.lane(1) - _CAR / 2 - 0.7
        clear = (math.sqrt(max(2 * radius**2 - _WAITING**2, 0.0)) - _WAITING) / 2
        return max(self.stop - clear, self.half_width + _WAITING + 0.5)

    def at(self, arm: str, away: float, aside: float) -> tuple[float, float]:
        """A point `away` from the centre on an arm and `aside` of its middle, right as one comes from it [m]."""
        hx, hy = ARMS[arm]
        return -hx * away + hy * aside + 0.0, -hy * away - hx * aside + 0.0

    def buildings(self) -> dict[str, list[tuple[float, float]]]:
        """Name -> corners [m] of the buildings: one per corner, one along the side without arm."""
        if not self.setback:
            return {}
        wall, far = self.half_width + self.setback, _BUILDING
        corner = max(self.half_width + self.stop, 2 * self._waiting_corner)  # x + y
        chamfer = corner - self.half_width + self.setback * (math.sqrt(2) - 1)
        end = max(far, chamfer + 10.0)
        outlines = {}
        for arm in ARMS:
            left = LEFT[arm]
            if arm in self.arms and left in self.arms:
                # Seen from `arm`, to the left: its own wall, the cut corner, the wall along the other arm.
                ring = [(chamfer, -wall), (end, -wall), (end, -end), (wall, -end), (wall, -chamfer)]
                outlines[f"building_{arm}{left}"] = [self.at(arm, *p) for p in ring]
            elif arm not in self.arms:
                ring = [(wall, -end), (wall, end), (wall + 15.0, end), (wall + 15.0, -end)]
                outlines[f"building_{arm}"] = [self.at(arm, *p) for p in ring]
        return outlines
