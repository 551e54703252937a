"""`w2t`: type W2T of Yan et al. 2025, Table 1.

Three arms, our assumption for the T, and three oncoming lanes: a = 11.0 m = 1.4 + 3 x 2.8 + 0.3 (green strip)
+ 0.9.
The widths are our assumption; a is printed ("average width", read as this offset in shared/seeds.md 4.1).

    python -m sumo_nets.build w2t
"""

from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(
    arms="nsw",
    lanes=3,
    separation=0.3,
    bike_lane=1.8,
    contraflow=True,
    setback=3.0,
)
