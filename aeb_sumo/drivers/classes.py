"""Driver classes of Zheng et al. 2020: groups of drivers whose reaction times depend on speed in the same way.

Zheng G., Zu Z., Kong Z.: AEB collision avoidance strategy based on driver reaction time. Journal of Chongqing
University of Technology (Natural Science), 2020 no. 12. A straight line, reaction time against relative speed, is
fitted to each of nine groups, and the lines are clustered into four classes. Their Tables 2 and 3 are lost: the
packaged file holds invented lines (shared/seeds.md 5.3, A27, D5).
"""

import csv
import math
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from aeb_sumo.errors import InputError
from aeb_sumo.soa import Floats

__all__ = ["CLASSES", "FITTED_KMH", "DriverClass", "distances", "driver_classes", "reaction_time"]

CLASSES = 4
"""Classes, printed."""

FITTED_KMH = (0.0, 60.0)
"""Relative speeds of the experiment [km/h], printed."""

_GROUP = ("age_years", "sex", "experience_years")
_SLOPE, _INTERCEPT = "slope_s_per_kmh", "intercept_s"


@dataclass(frozen=True, kw_only=True)
class DriverClass:
    """The mean line of a class.

    Attributes:
        slope: rise of the reaction time with the relative speed [s per km/h].
        intercept: reaction time at standstill [s].
        groups: the groups of drivers in it, as in the file: age, sex, experience.
    """

    slope: float
    intercept: float
    groups: tuple[str, ...]


def distances(lines: Floats) -> Floats:
    """Matrix (n, n) of `d = sqrt((a_i - a_m)^2 + (b_i - b_m)^2)` between lines (n, 2): slope, intercept.

    The formula is inferred from the source's list of symbols (seeds 5.1). As there, s per km/h and s are added up, so
    that in practice the intercepts decide.
    """
    result: Floats = np.linalg.norm(lines[:, None] - lines[None], axis=-1)
    return result


@cache
def driver_classes(path: str | Path | None = None) -> tuple[DriverClass, ...]:
    """Classes 1 to 4, from the slowest to the fastest at 30 km/h.

    The source does not name its clustering; average linkage is our assumption, and so is the order.

    Args:
        path: comma-separated lines of reaction time, with the columns of the packaged synthetic file, which None takes.

    Raises:
        InputError: the file cannot be read or holds what no driver can have; the message names file, row, field, value
            and what is allowed.
    """
    groups, lines = _read(path)
    # Only runs with driver classes need them, and they take long to import.
    from scipy.cluster.hierarchy import cut_tree, linkage  # noqa: PLC0415
    from scipy.spatial.distance import squareform  # noqa: PLC0415

    cluster = cut_tree(linkage(squareform(distances(lines)), "average"), n_clusters=CLASSES)[:, 0]
    classes = [
        DriverClass(
            slope=float(lines[cluster == c, 0].mean()),
            intercept=float(lines[cluster == c, 1].mean()),
            groups=tuple(group for group, member in zip(groups, cluster == c, strict=True) if member),
        )
        for c in range(CLASSES)
    ]
    return tuple(sorted(classes, key=lambda c: c.intercept + 30 * c.slope, reverse=True))


def reaction_time(classes: tuple[DriverClass, ...], cls: ArrayLike, speed_kmh: ArrayLike) -> Floats:
    """Reaction time `T_i(v)` [s].

    Args:
        classes: as from `driver_classes`.
        cls: number of the class, 1 to 4; broadcasts with the speed.
        speed_kmh: relative speed [km/h]; outside 0 to 60 the end of the fitted range holds, our assumption.
    """
    index = np.asarray(cls) - 1
    slope, intercept = np.array([c.slope for c in classes]), np.array([c.intercept for c in classes])
    result: Floats = intercept[index] + slope[index] * np.clip(np.asarray(speed_kmh, float), *FITTED_KMH)
    return result


def _read(path: str | Path | None) -> tuple[list[str], Floats]:
    """Names of the groups and their lines (n, 2)."""
    source = Path(path) if path is not None else files("aeb_sumo.drivers") / "data" / "zheng2020_synthetic.csv"
    try:
        text = source.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"cannot read the driver classes {source}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise InputError(f"the driver classes {source} are no text in UTF-8") from None

    rows = [(n, line) for n, line in enumerate(text.splitlines(), 1) if line.strip() and not line.startswith("#")]
    header = next(csv.reader([rows[0][1]])) if rows else []
    for column in (*_GROUP, _SLOPE, _INTERCEPT):
        if column not in header:
            raise InputError(f"{source}: column {column} is missing; there are: {', '.join(header) or 'none'}")

    groups, lines = [], []
    for number, line in rows[1:]:
        record = dict(zip(header, next(csv.reader([line])), strict=False))
        where = f"{source}, row {number}"
        slope, intercept = (_number(where, field, record.get(field, "")) for field in (_SLOPE, _INTERCEPT))
        if intercept < 0:
            raise InputError(f"{where}: {_INTERCEPT} is {intercept:g}; allowed: 0 or more")
        if intercept + slope * FITTED_KMH[1] < 0:
            least = -intercept / FITTED_KMH[1]
            raise InputError(
                f"{where}: {_SLOPE} is {slope:g}; allowed: {least:g} or more, "
                f"so that no reaction time within 0..60 km/h is negative"
            )
        groups.append(", ".join(record.get(field, "") for field in _GROUP))
        lines.append((slope, intercept))
    if len(lines) < CLASSES:
        raise InputError(f"{source}: {len(lines)} rows; allowed: {CLASSES} or more, for {CLASSES} classes")
    return groups, np.array(lines)


def _number(where: str, field: str, text: str) -> float:
    """A finite number."""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InputError(f"{where}: {field} is {text!r}; allowed: a finite number")
    return value
