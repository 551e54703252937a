"""How the runs can be made again."""

from collections.abc import Mapping

import pandas as pd

from aeb_sumo.results.command import arguments, shell
from analysis.load import Dataset
from analysis.report.intervals import records
from analysis.report.parts import Cell, Quantity, Section, Table, count

__all__ = ["section"]

_INTERVAL = 60.0  # s, the command's own default


def section(data: Dataset, groups: Mapping[str, Dataset]) -> Section:
    """Command lines by group of runs, versions, and every run with its books.

    Args:
        data: all runs.
        groups: `data.by_group()`.
    """
    code: list[tuple[str, str]] = []
    for name, part in groups.items():
        lines: dict[tuple[str, ...], list[int]] = {}
        for run in part.runs.sort_values(["seed", "run_id"]).pipe(records):
            words = [
                *arguments(run, seed=False),
                *_verdicts(part),
                *_ceilings(data, run),
                *_interval(part.traffic, run),
            ]
            lines.setdefault(tuple(words), []).append(int(run["seed"]))
        for line, seeds in lines.items():
            code += [(f"{name}: {_seeds(seeds)}", _line(list(line), seeds, f"again/{len(code) + 1}"))]
    versions = data.runs[["aeb_sumo_version", "sumo_version"]].drop_duplicates()
    made = "; ".join(f"aeb-sumo {a}, {s}" for a, s in versions.itertuples(index=False))
    text = (
        f"Made by {made}. The same versions, settings and seed give the same tables, bit for bit. Files that the lines "
        "name (a .sumocfg, a driver profile) must be the same, too.",
    )
    return Section(id="repeat", title="How to repeat it", text=[text], code=code, tables=[_runs(data)])


def _verdicts(part: Dataset) -> list[str]:
    """Which interventions got a verdict: all, or a sample as large as the largest of a run."""
    told = part.interventions["verdict"].fillna("") != ""
    if not told.any():
        return []
    largest = part.interventions[told].groupby("run_id").size().max()
    return ["--verdicts", "all" if told.all() else f"sample:{largest}"]


def _ceilings(data: Dataset, run: dict[str, object]) -> list[str]:
    """Whether it was asked who could have avoided the crashes; for the rows of the AEB itself it takes `--compare`."""
    return ["--ceilings"] if (data.ceilings["run_id"] == run["run_id"]).any() else []


def _interval(traffic: pd.DataFrame, run: dict[str, object]) -> list[str]:
    """The interval of table `traffic`, where it is not the default and shows."""
    own = traffic[traffic["run_id"] == run["run_id"]]
    if own["begin_s"].nunique() < 2:
        return []
    length = round(float((own["end_s"] - own["begin_s"]).max()), 6)
    return [] if length == _INTERVAL else ["--interval", f"{length:g}"]


def _seeds(seeds: list[int]) -> str:
    return f"seed {seeds[0]}" if len(seeds) == 1 else f"{len(seeds)} seeds"


def _line(words: list[str], seeds: list[int], folder: str) -> str:
    if len(seeds) == 1:
        return f"{shell([*words, '--seed', str(seeds[0])])} --out {folder}"
    body = f'{shell(words)} --seed "$seed" --out {folder}/"$seed"'
    return f"for seed in {' '.join(map(str, seeds))}; do\n    {body}\ndone"


def _runs(data: Dataset) -> Table:
    head = ("run", "outcome", "seed", "simulated", "vehicles", "equipped", "crashes", "override violations")
    rows: list[list[Cell]] = []
    for run in records(data.runs.sort_values("run_id")):
        key = f"run/{run['run_id']}"
        outcome = f"{run['outcome']}: {run['reason']}" if run["reason"] else str(run["outcome"])
        books = [count(f"{key}/{c}", run[c]) for c in ("vehicles", "equipped", "crashes", "override_violations")]
        span = Quantity(key=f"{key}/span", value=run["end_s"] - run["begin_s"], unit="s")
        rows.append([run["run_id"], outcome, str(int(run["seed"])), span, *books])
    return Table(id="runs", title=f"All {len(rows)} runs", head=head, rows=rows, folded=True)
