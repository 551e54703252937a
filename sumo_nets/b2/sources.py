"""`b2`: type B2 of Yan et al. 2025, Table 1.

W2 with a median of 4.6 m: a = 16.3 m = 1.5 + 4.6 + 3 x 3.0 + 0.3 (green strip) + 0.9.
The widths are our assumption; a is printed ("average width", read as this offset in shared/seeds.md 4.1).

    python -m sumo_nets.build b2
"""

from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(
    lanes=3,
    lane_width=3.0,
    median=4.6,
    separation=0.3,
    bike_lane=1.8,
    contraflow=True,
    setback=3.0,
)
