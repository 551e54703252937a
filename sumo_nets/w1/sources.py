"""`w1`: type W1 of Yan et al. 2025, Table 1.

No median, two oncoming lanes: a = 7.9 m = 1.4 + 2 x 2.8 + 0.9.
The widths are our assumption; a is printed ("average width", read as this offset in shared/seeds.md 4.1).

    python -m sumo_nets.build w1
"""

from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(
    lanes=2,
    bike_lane=1.8,
    contraflow=True,
    setback=3.0,
)
