"""Kinds of vehicles: SUMO's classes, and what is assumed of each."""

__all__ = ["VClasses", "mass"]


class VClasses:
    """SUMO's vehicle classes, as groups."""

    CARS = frozenset({"passenger", "private", "hov", "vip", "taxi", "evehicle", "ignoring", "custom1", "custom2"})
    """Cars; "ignoring" is what scenarios give a car that may drive where others may not."""
    DRIVEN = CARS | {"delivery", "truck", "trailer", "bus", "coach", "emergency", "authority", "army"}
    """Motor vehicles with a driver who can look away."""
    HEAVY = frozenset({"truck", "trailer", "bus", "coach"})
    """Of these, heavy ones."""
    RIDERS = frozenset({"bicycle", "moped", "scooter", "motorcycle"})
    """Two-wheelers."""
    VULNERABLE = RIDERS | {"pedestrian"}
    """Nobody around them: two-wheelers and pedestrians."""
    ALL = DRIVEN | RIDERS | {
        "tram", "rail_urban", "rail", "rail_electric", "rail_fast", "ship", "container", "cable_car", "subway",
        "aircraft", "wheelchair", "drone", "pedestrian",
    }  # fmt: skip
    """All that SUMO knows."""


# Masses by class [kg]: car and e-bike from another source (evidence.md, assumption there); the rest our assumption.
_MASS = {
    "bicycle": 120.0, "scooter": 120.0, "moped": 180.0, "motorcycle": 280.0, "pedestrian": 75.0, "delivery": 3000.0,
    "emergency": 3000.0, "truck": 12000.0, "trailer": 30000.0, "bus": 14000.0, "coach": 16000.0, "tram": 40000.0,
}  # fmt: skip
_CAR_MASS = 1500.0


def mass(vclass: str) -> float:
    """Of a vehicle of that class [kg]."""
    return _MASS.get(vclass, _CAR_MASS)
