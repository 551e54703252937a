"""What there is for sensors to measure."""

from dataclasses import dataclass

from aeb_sumo.soa import Bools, Floats

__all__ = ["Measurable"]


@dataclass(frozen=True)
class Measurable:
    """What there is to be measured of each target, (n,) each: the truth.

    Attributes:
        in_view: the geometry lets a sensor see it.
        distance: to its near side, along the own path or straight ahead [m].
        closing: speed at which that shrinks [m/s].
        closing_accel: how fast that speed grows [m/s2].
        left: lateral position in the own frame [m].
        closing_left: own lateral velocity less the target's [m/s].
        closing_left_accel: how fast that grows [m/s2].
        bearing: of what can be seen of it, from straight ahead, >= 0 [rad].
        overlap: share of its width in the own width, 0 to 1.
        own_accel: own acceleration in the last step, which the vehicle knows [m/s2].
        turn: how far the own frame has turned to the left in the last step [rad]; 0 where distance is along a path.
    """

    in_view: Bools
    distance: Floats
    closing: Floats
    closing_accel: Floats
    left: Floats
    closing_left: Floats
    closing_left_accel: Floats
    bearing: Floats
    overlap: Floats
    own_accel: Floats
    turn: Floats
