"""Pytest plugin: small runs whose numbers are compared with a golden table in the user's repository.

    def test_city(aeb_golden):
        aeb_golden("city.sumocfg", MyStrategy(comfort_decel=5.0), duration=60)

The table of `test_x.py` is `test_x.golden.toml` beside it: one section per run, one line per event. `pytest
--update-golden` writes the sections of the tests that ran.

Every pytest run in the environment loads this module: what is slow to import waits for the first use of the fixture.
"""

import fcntl
import json
import math
import os
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from aeb_sumo.errors import InputError

if TYPE_CHECKING:
    from aeb_sumo.results import Results
    from aeb_sumo.scenarios import Scenario
    from aeb_sumo.strategies.base import Strategy

__all__ = ["Golden", "aeb_golden", "pytest_addoption"]

Entry = dict[str, Any]

_HEADER = "# Written by `pytest --update-golden`. Single events: the first five; those that brake go before warnings.\n"
_LISTED = 5
_DECIMALS = 3
_CRASH = ["time_s", "kind", "impact_speed_mps"]
_TIMES = ["begin_s", "brake_s", "full_brake_s", "end_s"]
_GAPS = ["trigger_gap_m", "min_gap_m"]
_INTERVENTION = ["phase", "target", *_TIMES, "ended_by", *_GAPS, "max_decel_mps2", "speed_reduction_mps"]


def pytest_addoption(parser: pytest.Parser) -> None:
    """Add `--update-golden`."""
    parser.getgroup("aeb-sumo").addoption(
        "--update-golden", action="store_true", help="write the golden tables of aeb_golden instead of comparing"
    )


@pytest.fixture
def aeb_golden(request: pytest.FixtureRequest) -> "Golden":
    """Runs a small scenario and compares its numbers with the golden table beside the test file."""
    return Golden(path=request.path.with_suffix(".golden.toml"), update=request.config.getoption("update_golden"))


@dataclass(frozen=True, kw_only=True)
class Golden:
    """The golden table of a test module; call it to run a scenario and compare.

    Attributes:
        path: of the table, TOML.
        update: write instead of comparing.
    """

    path: Path
    update: bool

    def __call__(
        self,
        scenario: "str | Path | Scenario",
        strategy: "str | Strategy | None" = None,
        *,
        name: str | None = None,
        tolerance: float = 0.0015,
        **run_arguments: Any,
    ) -> "Results":
        """Run a scenario; the test fails when its numbers differ from the golden ones.

        Args:
            scenario: what is simulated: a name, the path of a .sumocfg, or a scenario.
            strategy: the AEB, or its name; None for zhao2025, or what `equip` says. Its parameters are not part of the
                section's name: they are what is tuned.
            name: of the section; None for scenario, strategy and the numbers and texts among `run_arguments`. Runs
                of one module that differ otherwise need names.
            tolerance: largest difference of numbers that are no counts, in their own unit. They are kept to three
                decimals; counts and names are compared exactly.
            run_arguments: as for `aeb_sumo.simulate.run`.

        Returns:
            The tables of the run.
        """
        try:
            key, results = _run(scenario, strategy, run_arguments)
            key, entry = name or key, _figures(results)
            if self.update:
                self._write(key, entry)
                return results
            golden = self._read().get(key)
        except InputError as error:
            raise pytest.fail.Exception(str(error), pytrace=False) from None
        if golden is None:
            pytest.fail(f"no golden numbers of {key!r} yet: run `pytest --update-golden` ({self.path})", pytrace=False)
        if moved := list(_moved(golden, entry, tolerance)):
            head = f"{key!r} moved; to accept run `pytest --update-golden` ({self.path}):"
            pytest.fail("\n  ".join([head, *moved]), pytrace=False)
        return results

    def _read(self) -> dict[str, Entry]:
        try:
            entries = tomllib.loads(self.path.read_text(encoding="utf-8"))
        except FileNotFoundError:
            return {}
        except (OSError, ValueError) as error:
            raise InputError(f"cannot read {self.path}: {error}") from None
        if not all(isinstance(entry, dict) for entry in entries.values()):
            raise InputError(f"cannot read {self.path}: it has lines outside of any section")
        return entries

    def _write(self, key: str, entry: Entry) -> None:
        """Replace one entry; the lock is for the other workers of pytest-xdist."""
        folder = os.open(self.path.parent, os.O_RDONLY)
        try:
            fcntl.flock(folder, fcntl.LOCK_EX)
            entries = sorted((self._read() | {key: entry}).items())
            partial = self.path.with_name(f".{self.path.name}.partial")
            partial.write_text(_HEADER + "".join(_section(*e) for e in entries), encoding="utf-8")
            partial.replace(self.path)
        except OSError as error:
            raise InputError(f"cannot write {self.path}: {error.strerror}") from None
        finally:
            os.close(folder)


def _run(
    scenario: "str | Path | Scenario", strategy: "str | Strategy | None", arguments: Mapping[str, Any]
) -> "tuple[str, Results]":
    """The run, and its name in the table."""
    from aeb_sumo import scenarios, simulate  # noqa: PLC0415 - slow

    if isinstance(scenario, str | Path):
        path = Path(scenario)
        scenario = scenarios.from_sumocfg(path) if path.suffix == ".sumocfg" else scenarios.load(str(scenario))
    results = simulate.run(scenario, strategy, **arguments)
    parts = [
        f"{k}={v:.12g}" if isinstance(v, Real) else f"{k}={v}"
        for k, v in sorted(arguments.items())
        if isinstance(v, Real | str) and k != "equip"  # which `runs.strategy` says
    ]
    return " ".join([Path(scenario.name).stem, results.runs["strategy"].item(), *parts]), results


def _figures(results: "Results") -> Entry:
    """What is compared; what does not apply is left out."""
    runs, crashes, exposure = results.runs, results.crashes, results.exposure
    acts = results.interventions.sort_values(["begin_s", "vehicle"])
    acts["number"] = acts.groupby("vehicle").cumcount() + 1
    distance, time = exposure["distance_m"].sum(), exposure["time_s"].sum()
    return _rounded(
        {
            "outcome": runs["outcome"].item(),
            "vehicles": runs["vehicles"].item(),
            "arrived": int(results.traffic["arrived"].sum()),
            "distance_km": distance / 1000,
            "mean_speed_mps": distance / time if time else math.nan,
            "crashes": crashes["kind"].value_counts().sort_index().to_dict(),
            "interventions": acts["phase"].value_counts().sort_index().to_dict(),
            "first_intervention_s": acts["begin_s"].min(),
            "first_braking_s": acts["brake_s"].min(),
            "min_gap_m": acts["min_gap_m"].min(),
            "max_decel_mps2": acts["max_decel_mps2"].max(),
            "intervention_mean": acts[[*_TIMES, *_GAPS]].mean().to_dict(),
        }
        | {
            f"crash of {row['striker']} with {row['struck']}": {k: row[k] for k in _CRASH}
            for row in crashes.sort_values("time_s").head(_LISTED).to_dict("records")
        }
        | {
            f"intervention {row['number']} of {row['vehicle']}": {k: row[k] for k in _INTERVENTION}
            for row in acts.sort_values(["brake_s", "begin_s", "vehicle"]).head(_LISTED).to_dict("records")
        }
    )


def _rounded(entry: Mapping[str, Any]) -> Entry:
    """Without what is nan."""
    kept: Entry = {}
    for key, value in entry.items():
        if isinstance(value, dict):
            kept[key] = _rounded(value)
        elif not isinstance(value, float):
            kept[key] = value
        elif not math.isnan(value):
            kept[key] = round(float(value), _DECIMALS) + 0.0  # no -0.0
    return kept


def _moved(golden: Any, now: Any, tolerance: float, path: str = "") -> Iterator[str]:
    """A line for each number that differs: `intervention 1 of car.3: brake_s: 12.300 -> 12.500`."""
    if isinstance(golden, dict) and isinstance(now, dict):
        for key in golden | now:
            yield from _moved(golden.get(key), now.get(key), tolerance, f"{path}{key}: ")
    elif isinstance(golden, float) and isinstance(now, float):
        if golden != now and not abs(golden - now) <= tolerance + 1e-9:
            yield f"{path}{golden:.{_DECIMALS}f} -> {now:.{_DECIMALS}f}"
    elif golden != now:
        yield f"{path}{_toml(golden)} -> {_toml(now)}"


def _section(key: str, entry: Entry) -> str:
    return "\n".join(["", f"[{json.dumps(key, ensure_ascii=False)}]", *(_pair(k, v) for k, v in entry.items()), ""])


def _pair(key: str, value: Any) -> str:
    return f"{key if key.isidentifier() and key.isascii() else json.dumps(key, ensure_ascii=False)} = {_toml(value)}"


def _toml(value: Any) -> str:
    """A value on one line; "none" for what is not there."""
    if isinstance(value, dict):
        return "{" + ", ".join(_pair(k, v) for k, v in value.items()) + "}"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return "none" if value is None else repr(value)
