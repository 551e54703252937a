"""`crossroads`: W0 without signals; north-south has priority.

python -m sumo_nets.build crossroads
"""

from sumo_nets.intersection import Intersection

INTERSECTION = Intersection(signal=False, setback=3.0)
