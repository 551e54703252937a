"""`w0`: type W0 of Yan et al. 2025, Table 1.

No median, one oncoming lane: a = 4.8 m = half the own lane 1.4 + 2.8 + half the bicycle lane 0.6.
The widths are our assumption; a is printed ("average width", read as this offset in shared/seeds.md 4.1).

    python -m sumo_nets.build w0
"""

from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(
    contraflow=True,
    setback=3.0,
)
