"""A user's own intersection: parameters to a folder that SUMO, and so `aeb-sumo run --sumocfg`, can run."""

import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import changed
from aeb_sumo.scenarios.demand import LATERAL_RESOLUTION, TELEPORT_AFTER, Demand, routes
from sumo_nets import plain
from sumo_nets.build import convert
from sumo_nets.intersection import Intersection

__all__ = ["NAME", "from_parameters", "write"]

NAME = "intersection"
"""Of the files."""

_DEMAND = "demand"

_CONFIGURATION = """<configuration>
    <input>
        <net-file value="{name}.net.xml"/>
        <route-files value="{name}.rou.xml"/>
        <additional-files value="{name}.add.xml"/>
    </input>
    <time>
        <end value="1800"/>
        <step-length value="0.1"/>
    </time>
    <processing>
        <lateral-resolution value="{resolution:g}"/>
        <time-to-teleport value="{teleport:g}"/>
    </processing>
</configuration>
"""


def from_parameters(values: Mapping[str, Any]) -> tuple[Intersection, Demand]:
    """Intersection and traffic from parameters by name: those of `Intersection`, and of `Demand` under `demand`.

    Args:
        values: as from `aeb_sumo.parameters`, for example `{"lanes": 2, "demand": {"flow": 900}}`.

    Raises:
        InputError: there is no such parameter, its value is of the wrong type or out of range, or what comes out cannot
            be built.
    """
    of_demand: dict[str, Any] = {}
    of_intersection: dict[str, Any] = {}
    for path, value in values.items():
        first, _, rest = path.partition(".")
        if first != _DEMAND:
            of_intersection[path] = value
        elif rest:
            of_demand[rest] = value
        elif isinstance(value, Mapping):
            of_demand.update(value)
        else:
            raise InputError(f"{_DEMAND} must be a table with parameters of the traffic, not {value!r}")
    try:
        return changed(Intersection(), of_intersection), changed(Demand(), of_demand)
    except ValueError as error:
        raise InputError(str(error)) from None


def write(intersection: Intersection, demand: Demand, folder: Path) -> Path:
    """Build net, buildings, routes and configuration in a folder, which gets all of them or none.

    Returns:
        The .sumocfg.

    Raises:
        InputError: the folder is not empty or cannot be made, or netconvert is missing or refuses the net.
    """
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        what = "is not empty" if folder.is_dir() else "is a file"
        raise InputError(f"--out {folder} {what}; name a new or empty folder")
    with tempfile.TemporaryDirectory() as elsewhere:
        made = Path(elsewhere) / NAME
        made.mkdir()
        plain.write(intersection, made, NAME)
        (made / f"{NAME}.rou.xml").write_text(routes(intersection, demand), encoding="utf-8")
        configuration = _CONFIGURATION.format(name=NAME, resolution=LATERAL_RESOLUTION, teleport=TELEPORT_AFTER)
        (made / f"{NAME}.sumocfg").write_text(configuration, encoding="utf-8")
        try:
            convert(made, NAME)
        except FileNotFoundError as error:
            raise InputError(str(error)) from None
        except subprocess.CalledProcessError as error:
            raise InputError(f"netconvert: {' '.join(str(error.stderr).split())}") from None
        try:
            folder.parent.mkdir(parents=True, exist_ok=True)
            shutil.copytree(made, folder, dirs_exist_ok=True)
        except OSError as error:
            raise InputError(f"cannot write --out {folder}: {error.strerror}") from None
    return folder / f"{NAME}.sumocfg"
