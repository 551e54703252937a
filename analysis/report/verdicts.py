"""What would have happened without: the verdicts of the interventions."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.interventions import equipped_km
from analysis.load import Dataset
from analysis.report.drawing import INK, VERDICTS, canvas, empty, svg
from analysis.report.intervals import per_1000_km, share
from analysis.report.matching import is_baseline
from analysis.report.parts import Cell, Figure, Quantity, Section, Table, Text, count, number

__all__ = ["Judged", "card_lines", "figures", "judged", "section"]

_TITLE = "Was it needed? Verdicts"


@dataclass(frozen=True)
class Judged:
    """The interventions of a group that have a verdict.

    Attributes:
        all: their rows, also those whose verdict is unknown.
        known: rows with a known verdict, and column `seed`.
        without: interventions that have no verdict.
        km: distance of the equipped vehicles [km].
    """

    all: pd.DataFrame
    known: pd.DataFrame
    without: int
    km: float

    def count(self, verdict: str) -> int:
        """Interventions with this verdict."""
        return int((self.all["verdict"] == verdict).sum())

    def share(self, key: str, verdict: str) -> Quantity:
        """Their share of those with a known one."""
        return share(key, self.known["verdict"] == verdict, self.known["seed"], "verdicts")


def judged(groups: Mapping[str, Dataset]) -> dict[str, Judged]:
    """Of every group with an AEB."""
    result = {}
    for name, part in groups.items():
        if not is_baseline(name):
            told = part.interventions["verdict"].fillna("")
            rows = part.interventions[told != ""]
            known = rows[rows["verdict"] != "unknown"]
            known = known.assign(seed=known["run_id"].map(part.runs.set_index("run_id")["seed"]))
            result[name] = Judged(rows, known, int((told == "").sum()), float(equipped_km(part).sum()))
    return result


def card_lines(group: str, some: Judged) -> list[tuple[str, Text]]:
    """Lines for the answer's card."""
    if not len(some.all) + some.without:
        return [("interventions", ("none",))]
    if not len(some.known):
        return [("verdicts", ("unknown: none was asked for" if not len(some.all) else "all unknown",))]
    lines: list[tuple[str, Text]] = []
    for verdict, label in (("avoided", "interventions that avoided a crash"), ("unneeded", "interventions not needed")):
        key = f"{group}/card/{verdict}"
        seen = count(f"{key}/count", some.count(verdict))
        lines.append((label, (seen, ": ", some.share(f"{key}/share", verdict))))
    return lines


def section(groups: Mapping[str, Judged]) -> Section | None:
    """The numbers of the verdicts; None without any run with an AEB."""
    if not groups:
        return None
    if not any(len(some.all) for some in groups.values()):
        why = (
            "No intervention has a verdict: none was asked for when these runs were made, so whether an intervention "
            "was needed is unknown here."
            if any(some.without for some in groups.values())
            else "There was no intervention, so there is nothing to judge."
        )
        return Section(id="verdicts", title=_TITLE, text=[(why,)])
    table = Table(
        id="verdict-table", title="Verdicts", head=("group", "verdict", "interventions", "share", "rate"),
        rows=[row for name, some in groups.items() for row in _rows(name, some)],
        note="Share of the interventions with a known verdict; the seed is the cluster, as those of one pile-up depend "
        "on each other (of one seed alone: Wilson's interval). Rate over the distance of the equipped vehicles with "
        "the exact Poisson interval, which takes interventions as independent; none where only a sample has verdicts.",
    )  # fmt: skip
    text = (
        "When an intervention first acted on the world, by the brake or by a warning that reached the driver, the "
        "simulated world was forked. In the fork this one intervention was suppressed, all else being equal, and the "
        "verdict compares the two.",
    )
    return Section(id="verdicts", title=_TITLE, text=[text], tables=[table, _by_target(groups), *_unknown(groups)])


def _rows(group: str, some: Judged) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for verdict in VERDICTS:
        key, seen = f"{group}/verdict/{verdict}", some.count(verdict)
        told: Cell = "–" if verdict == "unknown" else some.share(f"{key}/share", verdict)
        rate: Cell = "–" if some.without else per_1000_km(f"{key}/rate", seen, some.km)
        rows.append([group, verdict, count(f"{key}/count", seen), told, rate])
    rows.append([group, "no verdict asked for", count(f"{group}/verdict/none/count", some.without), "–", "–"])
    return rows


def _by_target(groups: Mapping[str, Judged]) -> Table:
    rows: list[list[Cell]] = []
    for group, some in groups.items():
        for (kind, phase), part in some.all.groupby(["target_kind", "phase"]):
            key = f"{group}/verdict/{kind}/{phase}"
            counts = [count(f"{key}/{v}", (part["verdict"] == v).sum()) for v in VERDICTS]
            rows.append([group, str(kind), str(phase).replace("_", " "), *counts])
    head = ("group", "target", "phase reached", *VERDICTS)
    return Table(id="verdicts-by-target", title="Verdicts by target and phase", head=head, rows=rows, folded=True)


def _unknown(groups: Mapping[str, Judged]) -> list[Table]:
    rows: list[list[Cell]] = []
    for group, some in groups.items():
        why = some.all.loc[some.all["verdict"] == "unknown", "verdict_reason"].value_counts().sort_index()
        rows += [[group, str(r) or "no reason given", count(f"{group}/unknown/{r}", n)] for r, n in why.items()]
    head = ("group", "reason", "interventions")
    return [Table(id="unknown", title="Why a verdict is unknown", head=head, rows=rows)] if rows else []


def figures(groups: Mapping[str, Judged]) -> dict[str, Figure]:
    """Bars of the verdicts of every group that has any."""
    drawn = [name for name, some in groups.items() if len(some.all)]
    return {name: _bars(f"verdicts-{k}", name, groups[name]) for k, name in enumerate(drawn)}


def _bars(name: str, group: str, some: Judged) -> Figure:
    shown = [v for v in VERDICTS if v != "unknown"]
    listed = ", ".join(f"{v} {some.count(v)}" for v in shown)
    alt = f"Verdicts of {len(some.known)} interventions of {group}: {listed}; unknown {some.count('unknown')}."
    with canvas(2.6) as (figure, axes):
        if len(some.known):
            ends = []
            for y, verdict in enumerate(shown):
                each = some.share("", verdict)
                ends.append(float(np.nanmax([each.high, each.value])))
                axes.barh(y, each.value, color=VERDICTS[verdict], height=0.62)
                axes.plot([each.low, each.high], [y, y], color=INK, lw=1)
                axes.annotate(
                    f"{some.count(verdict)} ({number(each.value, 0)} %)", (ends[-1], y), xytext=(4, 0),
                    textcoords="offset points", va="center", fontsize=8.5,
                )  # fmt: skip
            axes.set(xlabel=f"share of {len(some.known)} interventions with a known verdict [%]")
            axes.set_xlim(0, 1.35 * max(ends))
            axes.set_xticks([t for t in axes.get_xticks() if t <= 100])
            axes.set_yticks(range(len(shown)), shown)
            axes.invert_yaxis()
            axes.grid(axis="y", visible=False)
        else:
            empty(axes, "all verdicts unknown")
        drawn = svg(figure, name, alt)
    return Figure(id=name, title=f"Verdicts: {group}", svg=drawn, alt=alt, note="Thin lines: 95 %, by seed.")
