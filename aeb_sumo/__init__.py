"""aeb-sumo: what an automatic emergency brake does to real traffic.

`aeb_sumo.simulate.run` goes from a scenario to results; `aeb_sumo.scenarios.load` makes a scenario. Importing this
package starts nothing and needs no SUMO.
"""

from importlib.metadata import version

__all__ = ["__version__"]

__version__ = version("aeb-sumo")
