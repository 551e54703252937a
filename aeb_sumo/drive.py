"""One run of a test case on the proving ground, and what sources report of it: instants, gaps, peaks."""

from collections.abc import Callable, Hashable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from functools import cached_property
from multiprocessing import get_context
from os import cpu_count
from typing import TypeVar

import numpy as np
import pandas as pd

from aeb_sumo.criticality import ttc
from aeb_sumo.scenarios import Scenario
from aeb_sumo.scenarios.cases import EGO, TARGET
from aeb_sumo.simulate import run
from aeb_sumo.soa import Bools, Floats
from aeb_sumo.strategies.base import Phase, Strategy
from aeb_sumo.trace import Trace
from aeb_sumo.world.boxes import Boxes, distance
from aeb_sumo.world.session import SumoError

__all__ = ["Case", "Drive", "body_distance", "drive", "drive_all"]

K = TypeVar("K", bound=Hashable)

_STANDS = 1e-3  # m/s
_OVER = 0.5  # s


@dataclass(frozen=True, kw_only=True)
class Case:
    """What is run: a scenario with an `ego` and a `target`, the AEB of the ego, its sensors and the seed.

    `until_over` ends it soon after a contact, or when the ego has braked and nothing closes in any more.
    """

    scenario: Scenario
    strategy: Strategy
    sensing: str = "ideal"
    seed: int = 1
    until_over: bool = True


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What came of a case. Times count from the start of the case, when both are on the road.

    Attributes:
        time: (k,) [s].
        ego, target: one row per instant, columns as in `aeb_sumo.trace.Trace.frame`.
        crash_time: instant of the contact [s], nan for none.
        crash_speed: the ego's own speed at contact [m/s], nan for none.
        impact_speed: relative speed at contact [m/s], nan for none.
    """

    time: Floats
    ego: pd.DataFrame
    target: pd.DataFrame
    crash_time: float
    crash_speed: float
    impact_speed: float

    @property
    def crashed(self) -> bool:
        """Whether there was a contact."""
        return bool(np.isfinite(self.crash_time))

    @cached_property
    def gap(self) -> Floats:
        """(k,) true gap bumper to bumper along the ego's heading [m]."""
        dx, dy = self.target["x_m"] - self.ego["x_m"], self.target["y_m"] - self.ego["y_m"]
        heading = self.ego["heading_rad"]
        along = dx * np.cos(heading) + dy * np.sin(heading)
        result: Floats = (along - self.target["length_m"]).to_numpy()
        return result

    @cached_property
    def closing(self) -> Floats:
        """(k,) closing speed of two on one line [m/s]."""
        result: Floats = (self.ego["speed_mps"] - self.target["speed_mps"]).to_numpy()
        return result

    @property
    def ttc(self) -> Floats:
        """(k,) time to collision [s]."""
        return ttc(gap=self.gap, closing_speed=self.closing)

    def first(self, condition: Bools) -> int:
        """Index of the first instant at which something holds; -1 if it never does."""
        return int(np.argmax(condition)) if np.any(condition) else -1

    @cached_property
    def warned(self) -> int:
        """Index of the first instant with a warning or more; -1 for none."""
        return self.first(self.ego["phase"].to_numpy() >= Phase.WARN)

    @cached_property
    def triggered(self) -> int:
        """Index of the first instant with a demand to brake; -1 for none."""
        return self.first(self.ego["phase"].to_numpy() >= Phase.PARTIAL_BRAKE)

    @cached_property
    def braking(self) -> int:
        """Index of the instant from which the brake acts; -1 for none."""
        return self.first(self.ego["decel_mps2"].to_numpy() > 0)

    @cached_property
    def ended(self) -> int:
        """Index of the first instant after that at which nothing closes in any more; the last instant for none."""
        after = np.arange(len(self.time)) > max(self.triggered, 0)
        found = self.first(after & (self.closing <= _STANDS))
        return found if found >= 0 else len(self.time) - 1

    def at(self, series: Floats, index: int) -> float:
        """`series[index]`, nan for an index of -1."""
        return float(series[index]) if index >= 0 else float("nan")

    @property
    def warn_time(self) -> float:
        """Instant of the warning [s]."""
        return self.at(self.time, self.warned)

    @property
    def warning_length(self) -> float:
        """From the warning to the demand to brake [s]."""
        return self.at(self.time, self.triggered) - self.warn_time

    @property
    def brake_length(self) -> float:
        """From the demand to brake until nothing closes in any more [s]."""
        return self.at(self.time, self.ended) - self.at(self.time, self.triggered)

    @property
    def final_gap(self) -> float:
        """Smallest gap; 0 after a contact [m]."""
        return 0.0 if self.crashed else float(np.min(self.gap))

    @property
    def peak(self) -> float:
        """Largest deceleration until nothing closes in any more [m/s2]."""
        until = self.time <= (self.crash_time if self.crashed else self.time[self.ended])
        return float(np.max(-self.ego["accel_mps2"].to_numpy()[until]))


def drive(case: Case) -> Drive:
    """Run a case in SUMO. One simulation per process at a time.

    Raises:
        SumoError: SUMO refused the case or gave up.
    """
    trace = Trace(EGO, TARGET)
    stop = _Over(trace) if case.until_over else None
    results = run(case.scenario, case.strategy, sensing=case.sensing, seed=case.seed, trace=trace, stop=stop)
    if results.runs["outcome"].iloc[0] == "failed":
        raise SumoError(str(results.runs["reason"].iloc[0]))
    frame = trace.frame()
    both = {name: part.set_index("time_s", drop=False) for name, part in frame.groupby("vehicle")}
    if len(both) < 2:
        raise SumoError(f"{case.scenario.name}: ego and target were never on the road together")
    together = both[EGO].index.intersection(both[TARGET].index)
    ego, target = (both[name].loc[together].reset_index(drop=True) for name in (EGO, TARGET))
    start = float(ego["time_s"].iloc[0])
    crash = results.crashes.iloc[0] if len(results.crashes) else None
    own = "striker" if crash is not None and crash["striker"] == EGO else "struck"
    return Drive(
        time=ego["time_s"].to_numpy() - start,
        ego=ego,
        target=target,
        crash_time=float("nan") if crash is None else float(crash["time_s"]) - start,
        crash_speed=float("nan") if crash is None else float(crash[f"{own}_speed_mps"]),
        impact_speed=float("nan") if crash is None else float(crash["impact_speed_mps"]),
    )


def drive_all(
    cases: Mapping[K, Case],
    *,
    workers: int | None = None,
    done: Callable[[], None] | None = None,
    failed: Callable[[K, SumoError], None] | None = None,
) -> dict[K, Drive]:
    """Run cases in SUMO, several processes at a time, one simulation each.

    Args:
        cases: by any key.
        workers: processes; None for one per processor.
        done: called after every case.
        failed: called for a case of which nothing came, which is then missing in the result; None: it ends all of them.

    Raises:
        SumoError: SUMO refused a case or gave up, and there is no `failed`.
    """
    result: dict[K, Drive] = {}
    # Processes of their own, as SUMO leaves traces in the one it ran in.
    with ProcessPoolExecutor(workers or cpu_count(), mp_context=get_context("spawn")) as pool:
        try:
            for key, future in {key: pool.submit(drive, case) for key, case in cases.items()}.items():
                try:
                    result[key] = future.result()
                except SumoError as error:
                    if failed is None:
                        raise
                    failed(key, error)
                if done is not None:
                    done()
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return result


class _Over:
    """An approach is over when, for a while, the ego has had contact, or has braked and nothing closes in any more."""

    def __init__(self, trace: Trace) -> None:
        self._trace = trace
        self._braked = False
        self._since = float("inf")

    def __call__(self) -> bool:
        rows = self._trace.latest
        if len(rows) < 2:
            return False
        ego, target = rows[EGO], rows[TARGET]
        self._braked |= ego["phase"] >= Phase.PARTIAL_BRAKE
        touching = np.hypot(target["x_m"] - ego["x_m"], target["y_m"] - ego["y_m"]) <= target["length_m"]
        if touching or (self._braked and ego["speed_mps"] - target["speed_mps"] <= _STANDS):
            self._since = min(self._since, ego["time_s"])
        else:
            self._since = float("inf")
        return bool(ego["time_s"] - self._since > _OVER)


def body_distance(first: pd.DataFrame, second: pd.DataFrame) -> Floats:
    """(k,) distance between the bodies of two vehicles, rows of a trace, as rectangles [m]."""
    columns = ("x_m", "y_m", "heading_rad", "length_m", "width_m")
    one, other = (Boxes.of(*(v[c].to_numpy(float) for c in columns)) for v in (first, second))
    return distance(one, other)
