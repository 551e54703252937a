"""Ceilings: would perfect braking, or a careful driver, have avoided the crashes of a baseline?

Runs are deterministic. So the baseline is run again, and some seconds before each of its crashes, which are known now,
the world is forked once per ceiling: in the fork the vehicles of the crash whose braking could help have the ceiling's
system, and nothing else is different.
"""

from aeb_sumo.ceilings.second import CEILINGS, ceilings

__all__ = ["CEILINGS", "ceilings"]
