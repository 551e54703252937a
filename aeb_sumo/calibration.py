"""Calibrating drivers: what a profile does on the highway without any AEB, beside the evidence (shared/evidence.md)."""

from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, field, replace
from multiprocessing import get_context
from os import cpu_count
from typing import Any

import numpy as np

from aeb_sumo import scenarios
from aeb_sumo.criticality import thw
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.engine import Engine
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import changed
from aeb_sumo.simulate import run
from aeb_sumo.soa import Floats
from aeb_sumo.world.kinds import VClasses
from aeb_sumo.world.session import SumoError

__all__ = [
    "ENOUGH",
    "FITTED",
    "GRID",
    "SHARES",
    "TARGET",
    "Line",
    "Observed",
    "best",
    "lines",
    "observe",
    "observe_all",
    "with_value",
]

TARGET = 761 / 82
"""Near-crashes per crash in the 100-Car study (evidence.md, V)."""

FITTED = "hard_braking.duration"
"""The parameter that is fitted to it: how long leads brake hard for no visible reason; there is no evidence for it."""

GRID = (1.6, 1.7, 1.8, 1.9, 2.0)
"""Values of it that are tried [s], our assumption; shorter ones give too few crashes to tell the ratio."""

ENOUGH = 15
"""Crashes from which on a ratio counts as known (to within a factor of about 1.7 either way), our assumption."""

SHARES = (0.0, 0.15, 0.3, 0.45, 0.6)
"""Shares of time with the eyes off the road at which crashes are counted."""

_SCENARIO = "highway"
_SAMPLE = 5.0  # s between two looks at the headways, our assumption
_FOLLOWS = 5.0  # s, who is farther behind does not follow, our assumption
_ROLLS = 10.0  # m/s, below this there are queues and no headways, our assumption


@dataclass(frozen=True)
class Observed:
    """What was seen in one or more runs without AEB.

    Attributes:
        near_crashes, crashes: primary rear-end ones.
        secondary: further crashes.
        vehicle_km: driven by all.
        away, driving: time of all drivers with the eyes off the road, and in all [s].
        glances: their durations [s].
        headways: time gaps of cars that follow [s].
        reactions: of drivers of cars, rows of late (0 or 1), delay [s], alpha: the delay as a share of the time to
            the crash.
        errors: striker's error -> crashes.
    """

    near_crashes: int = 0
    crashes: int = 0
    secondary: int = 0
    vehicle_km: float = 0.0
    away: float = 0.0
    driving: float = 0.0
    glances: tuple[float, ...] = ()
    headways: tuple[float, ...] = ()
    reactions: tuple[tuple[float, float, float], ...] = ()
    errors: Mapping[str, int] = field(default_factory=dict)

    def __add__(self, other: "Observed") -> "Observed":
        """Two together."""
        errors = {k: self.errors.get(k, 0) + other.errors.get(k, 0) for k in sorted({*self.errors, *other.errors})}
        sums = {f: getattr(self, f) + getattr(other, f) for f in self.__dataclass_fields__ if f != "errors"}
        return Observed(**sums, errors=errors)

    @property
    def ratio(self) -> float:
        """Near-crashes per crash; nan without crashes."""
        return self.near_crashes / self.crashes if self.crashes else float("nan")


class _Watch:
    """Records glances, headways and reactions."""

    def __init__(self) -> None:
        self.away = self.driving = 0.0
        self.glances: list[float] = []
        self.headways: list[float] = []
        self.reactions: list[tuple[float, float, float]] = []
        self._since: dict[int, float] = {}
        self._world: Engine

    def attend(self, world: Engine) -> None:
        """See `aeb_sumo.trace.Recorder`."""
        self._world = world

    def step(self, time: float) -> None:
        """See `aeb_sumo.trace.Recorder`."""
        t, leads, drivers = self._world.traffic, self._world.leads, self._world.motorists
        rows = t.present
        self.away += float(np.count_nonzero(drivers.away[rows])) * t.dt
        self.driving += len(rows) * t.dt
        away = set(np.flatnonzero(drivers.away & t.here).tolist())
        for slot in away - self._since.keys():
            self._since[slot] = time
        for slot in self._since.keys() - away:
            self.glances.append(time - self._since.pop(slot))
        self.reactions += [
            (n.late, n.delay, n.delay / n.time_to_crash)
            for n in drivers.noticed
            if n.time_to_crash > 0 and t.vclass[n.slot] in VClasses.CARS
        ]
        if len(rows) and round(time / t.dt) % round(_SAMPLE / t.dt) == 0:
            t.read(rows)
            lead, gap = (np.array(each) for each in zip(*(leads.now(slot) for slot in rows.tolist()), strict=True))
            follows = (lead >= 0) & (t.speed[rows] > _ROLLS)
            headways = thw(gap=gap[follows], speed=t.speed[rows[follows]])
            self.headways += headways[headways < _FOLLOWS].tolist()


def observe(profile: Profile, seed: int, duration: float) -> Observed:
    """One run of the highway without AEB.

    Raises:
        SumoError: SUMO gave up.
    """
    watch = _Watch()
    highway = replace(scenarios.load(_SCENARIO), drivers=profile)
    results = run(highway, "none", seed=seed, duration=duration, trace=watch)
    if results.runs["outcome"].iloc[0] == "failed":
        raise SumoError(str(results.runs["reason"].iloc[0]))
    primary = results.crashes[~results.crashes["secondary"].astype(bool) & (results.crashes["kind"] == "rear_end")]
    conflicts = results.conflicts
    near = conflicts["near_crash"] & ~conflicts["secondary"].astype(bool) & (conflicts["kind"] == "following")
    return Observed(
        near_crashes=int(near.sum()),
        crashes=len(primary),
        secondary=int(results.crashes["secondary"].sum()),
        vehicle_km=float(results.exposure["distance_m"].sum() / 1000),
        away=watch.away,
        driving=watch.driving,
        glances=tuple(watch.glances),
        headways=tuple(watch.headways),
        reactions=tuple(watch.reactions),
        errors={str(k): int(n) for k, n in primary["striker_error"].value_counts().items()},
    )


def observe_all(
    profiles: Sequence[Profile],
    seeds: Iterable[int],
    duration: float,
    *,
    workers: int | None = None,
    done: Callable[[], None] | None = None,
) -> list[Observed]:
    """What is seen with each profile, all seeds together; several processes at a time.

    Raises:
        InputError: a duration is not positive.
        SumoError: SUMO gave up.
    """
    if not 0 < duration < np.inf:
        raise InputError(f"duration must be a positive number of seconds, not {duration:g}")
    numbers = list(seeds)
    with ProcessPoolExecutor(workers or cpu_count(), mp_context=get_context("spawn")) as pool:
        futures = [[pool.submit(observe, profile, seed, duration) for seed in numbers] for profile in profiles]
        try:
            totals = []
            for some in futures:
                total = Observed()
                for future in some:
                    total += future.result()
                    if done is not None:
                        done()
                totals.append(total)
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return totals


def with_value(profile: Profile, name: str, value: float) -> Profile:
    """A profile with one of its parameters changed.

    Raises:
        InputError: it has no such parameter, or the value is out of range.
    """
    section = name.partition(".")[0]
    if getattr(profile, section, None) is None:
        raise InputError(f"driver profile {profile.name} has no section [{section}]")
    return changed(profile, {name: value})


def best(values: Sequence[float], seen: Sequence[Observed]) -> float:
    """The value whose ratio is nearest to `TARGET`, as a factor, of those with `ENOUGH` crashes.

    Raises:
        InputError: none of them has.
    """
    apart = [abs(np.log(o.ratio / TARGET)) if o.near_crashes and o.crashes >= ENOUGH else np.inf for o in seen]
    if not np.isfinite(min(apart)):
        raise InputError(f"fewer than {ENOUGH} crashes with every value tried: take more seeds or a longer duration")
    return values[int(np.argmin(apart))]


@dataclass(frozen=True)
class Line:
    """One line of the comparison: a quantity, what was seen, what the evidence says and how sure that is."""

    quantity: str
    here: str
    evidence: str
    mark: str


def lines(seen: Observed) -> list[Line]:
    """The comparison with the evidence."""
    glances, reactions = np.array(seen.glances), np.array(seen.reactions).reshape(-1, 3)
    late, on = reactions[reactions[:, 0] == 1], reactions[reactions[:, 0] == 0]
    rate = seen.crashes / seen.vehicle_km * 1e6 if seen.vehicle_km else np.nan
    rows: list[tuple[str, str, Any, str]] = [
        ("near-crashes per crash, primary, rear end", f"{seen.ratio:.1f}", f"{TARGET:.1f} (100-Car)", "V"),
        ("  near-crashes / crashes", f"{seen.near_crashes} / {seen.crashes}", "761 / 82", "V"),
        ("  striker's error", _counts(seen.errors), "-", "-"),
        ("crashes per million vehicle-km", f"{rate:.0f}", "0.33 (all roads, US): far too many on purpose", "S"),
        ("time with the eyes off the road [%]", _share(seen.away, seen.driving), "15 to 20", "R"),
        ("glance, median [s]", _median(glances), "0.7 to 0.9", "R"),
        ("glances longer than 2 s [%]", _over(glances, 2.0), "about 5", "R"),
        ("glances longer than 1.7 s [%]", _over(glances, 1.7), "the tail before crashes (Liang 2014)", "V"),
        ("reactions with the eyes on the threat, cars", f"{len(on)}", "-", "-"),
        ("  alpha, median", _median(on[:, 2]), "0.22 (Markkula 2016)", "V"),
        ("  reaction time, 5 / 50 / 95 % [s]", _quantiles(on[:, 1], (0.05, 0.5, 0.95)), "-", "-"),
        ("reactions of eyes that came back late, cars", f"{len(late)}", "-", "-"),
        ("  alpha, median", _median(late[:, 2]), "0.25 (Markkula 2016)", "V"),
        ("  reaction time, 5 / 50 / 95 % [s]", _quantiles(late[:, 1], (0.05, 0.5, 0.95)), "-", "-"),
        ("  no braking at all [%]", _share(np.isinf(late[:, 1]).sum(), len(late)), "2.4 (Markkula 2016)", "V"),
        (
            "time gap of followers, 5 / 25 / 50 / 75 % [s]",
            _quantiles(np.array(seen.headways), (0.05, 0.25, 0.5, 0.75)),
            "log-normal (naturalistic studies)",
            "S",
        ),
    ]
    return [Line(*row) for row in rows]


def _counts(errors: Mapping[str, int]) -> str:
    return ", ".join(f"{name or 'none'} {n}" for name, n in sorted(errors.items())) or "-"


def _share(part: float, whole: float) -> str:
    return f"{100 * part / whole:.1f}" if whole else "-"


def _median(values: Floats) -> str:
    return f"{np.median(values):.2f}" if len(values) else "-"


def _over(values: Floats, limit: float) -> str:
    return f"{100 * np.mean(values > limit):.1f}" if len(values) else "-"


def _quantiles(values: Floats, at: tuple[float, ...]) -> str:
    if not len(values):
        return "-"
    return " / ".join(f"{q:.2f}" for q in np.quantile(values, at, method="inverted_cdf"))
