"""What is to be replayed: an event as the tables have it, and which other world it is set against."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from aeb_sumo.equipment import System
from aeb_sumo.errors import InputError
from aeb_sumo.repeat import settings
from aeb_sumo.results.reader import Stored

__all__ = ["RECENT", "Event", "find"]

RECENT = 10.0
"""An intervention that ended no longer than this before a crash has to do with it [s], our assumption."""

_NUMBERS = {"crash": ("crashes", "crash_id"), "intervention": ("interventions", "intervention_id")}
_LISTED = 12  # run ids in a message

Row = Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Event:
    """An event.

    Attributes:
        kind: `crash` or `intervention`.
        number: as in its table.
        run: row of `runs`.
        row: of `crashes` or `interventions`.
        intervention: the row of the intervention that does not take place in the other world; None: there is none, and
            in the other world there is an AEB where there was none.
        system: the AEB that is then put into both vehicles.
    """

    kind: str
    number: int
    run: Row
    row: Row
    intervention: Row | None
    system: System

    @property
    def instant(self) -> float:
        """Of the contact, or the beginning of the intervention [s]."""
        return float(self.row["time_s" if self.kind == "crash" else "begin_s"])

    @property
    def end(self) -> float:
        """Of the contact, or the end of the intervention [s]."""
        return float(self.row["time_s" if self.kind == "crash" else "end_s"])

    @property
    def ego(self) -> str:
        """Whom it is about: who intervened, else who struck."""
        return str(self.row["striker"] if self.intervention is None else self.intervention["vehicle"])

    @property
    def other(self) -> str:
        """The other one of the two: of a crash, or the target; empty for none."""
        if self.kind == "intervention":
            return str(self.row["target"])
        return str(next(self.row[who] for who in ("struck", "striker") if self.row[who] != self.ego))


def find(folder: Path, text: str, run_id: str | None = None) -> Event:
    """An event of a folder of results.

    Args:
        folder: with the tables.
        text: `crash:ID` or `intervention:ID`, the number as in the table.
        run_id: the run; None if only one of the folder has such an event.

    Raises:
        InputError: there are no results, or there is no such event, or it is not clear of which run.
    """
    written = re.fullmatch(r"(crash|intervention):(\d{1,9})", text.strip())
    if written is None:
        raise InputError(f"cannot read the event {text!r}; write crash:ID or intervention:ID, for example crash:0")
    kind, number = written[1], int(written[2])
    stored, (name, column) = Stored.of(folder), _NUMBERS[kind]
    runs: pd.DataFrame = stored.read("runs").to_pandas()
    if run_id is not None and run_id not in set(runs["run_id"]):
        raise InputError(f"no run {run_id!r} in {folder}; there are: {_listed(runs['run_id'])}")
    chosen = stored if run_id is None else stored.only([run_id])
    found: pd.DataFrame = chosen.read(name, filters=[(column, "==", number)]).to_pandas()
    if found.empty:
        counts = chosen.read(name, columns=["run_id"]).to_pandas().value_counts("run_id")
        there = _listed([f"{counts.get(run, 0)} in {run}" for run in chosen.run_ids])
        raise InputError(f"no {text} in {folder}; ids count from 0, and there are so many {name}: {there}")
    if len(found) > 1:
        raise InputError(f"{text} is in {len(found)} runs; choose one with --run: {_listed(found['run_id'])}")
    row = _row(found)
    run = _row(runs[runs["run_id"] == row["run_id"]])
    intervention = row if kind == "intervention" else _intervention(stored.only([row["run_id"]]), row)
    lived = runs[runs["end_s"].notna()]
    return Event(kind=kind, number=number, run=run, row=row, intervention=intervention, system=_system(lived, run))


def _intervention(stored: Stored, crash: Row) -> Row | None:
    """The last intervention by one of the two that was under way or just over; those on the other come first."""
    pair, time = (crash["striker"], crash["struck"]), crash["time_s"]
    filters = [("vehicle", "in", pair), ("begin_s", "<=", time), ("end_s", ">=", time - RECENT)]
    near: pd.DataFrame = stored.read("interventions", filters=filters).to_pandas()
    if near.empty:
        return None
    ordered = near.assign(mutual=near["target"].isin(pair)).sort_values(["mutual", "begin_s"], kind="stable")
    return _row(ordered.tail(1).drop(columns="mutual"))


def _system(runs: pd.DataFrame, run: Row) -> System:
    """The AEB that the run carries; of a baseline, that of another run, of the same scenario and seed if there is one.

    Of several systems in one run it is the first by name.
    """
    equipped = runs[runs["strategy"] != "none"]
    own = equipped["run_id"] == run["run_id"]
    seed = equipped["seed"] == run["seed"]
    scenario = equipped["scenario"] == run["scenario"]
    nearest = equipped.assign(near=own * 4 + scenario * 2 + seed).sort_values("near", ascending=False, kind="stable")
    for _, candidate in nearest.iterrows():
        return settings(dict(candidate)).equip.systems[0]
    return System.of("zhao2025")


def _row(frame: pd.DataFrame) -> Row:
    return {str(key): value for key, value in frame.iloc[0].items()}


def _listed(names: Any) -> str:
    names = sorted(names)
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")
