"""What would have happened without: the verdicts of the interventions."""

import pandas as pd

from analysis.interventions import equipped_km
from analysis.load import Dataset
from analysis.report.drawing import FAINT, INK, VERDICTS, canvas, svg
from analysis.report.intervals import per_1000_km, share
from analysis.report.matching import is_baseline
from analysis.report.parts import Cell, Figure, Section, Table, Text, count, number

__all__ = ["card_line", "figures", "section", "verdicts"]


def verdicts(data: Dataset) -> pd.Series:
    """Verdict of every intervention that has one."""
    found = data.interventions["verdict"].fillna("")
    return found[found != ""]


def card_line(group: str, part: Dataset) -> list[tuple[str, Text]]:
    """The line for the answer's card."""
    found = verdicts(part)
    known = found[found != "unknown"]
    if not len(part.interventions):
        return [("interventions", ("none",))]
    if not len(known):
        return [("verdicts", ("unknown: none was asked for",) if not len(found) else ("all unknown",))]
    lines: list[tuple[str, Text]] = []
    for verdict, label in (("avoided", "interventions that avoided a crash"), ("unneeded", "interventions not needed")):
        seen = int((known == verdict).sum())
        key = f"{group}/card/{verdict}"
        lines.append((label, (count(f"{key}/count", seen), ": ", share(key, seen, len(known), "verdicts"))))
    return lines


def figures(data: Dataset) -> list[Figure]:
    """Bars of the verdicts of every group that has any."""
    groups = {name: part for name, part in data.by_group().items() if not is_baseline(name)}
    return [_bars(name, part, k) for k, (name, part) in enumerate(groups.items()) if len(verdicts(part))]


def section(data: Dataset) -> Section | None:
    """The numbers of the verdicts; None without any run with an AEB."""
    groups = {name: part for name, part in data.by_group().items() if not is_baseline(name)}
    if not groups:
        return None
    if not len(verdicts(data)):
        why = (
            "No intervention has a verdict: none was asked for when these runs were made (aeb-sumo run --verdicts all), "
            "so whether an intervention was needed is unknown here."
            if len(data.interventions)
            else "There was no intervention, so there is nothing to judge."
        )
        return Section(id="verdicts", title="Was it needed? Verdicts", text=[(why,)])
    table = Table(
        id="verdict-table", title="Verdicts", head=("group", "verdict", "interventions", "share", "rate"),
        rows=[row for name, part in groups.items() for row in _rows(name, part)],
        note="Share of the interventions with a known verdict, Wilson's interval; rate over the distance of the equipped "
        "vehicles, exact Poisson interval, not given where only a sample has verdicts. Both take interventions as "
        "independent; those of one pile-up are not, so the intervals are somewhat too narrow.",
    )  # fmt: skip
    return Section(
        id="verdicts", title="Was it needed? Verdicts", tables=[table, *_by_target(groups), *_unknown(data)],
        text=[
            (
                "At the start of every intervention the simulated world was forked; in the fork this one intervention was "
                "suppressed, all else being equal, and the verdict compares the two futures.",
            )
        ],
    )  # fmt: skip


def _rows(group: str, part: Dataset) -> list[list[Cell]]:
    found = verdicts(part)
    known = int((found != "unknown").sum())
    complete = len(found) == len(part.interventions)
    km = float(equipped_km(part).sum())
    rows: list[list[Cell]] = []
    for verdict in VERDICTS:
        seen = int((found == verdict).sum())
        key = f"{group}/verdict/{verdict}"
        told: Cell = "–" if verdict == "unknown" else share(f"{key}/share", seen, known, "verdicts")
        rate: Cell = per_1000_km(f"{key}/rate", seen, km) if complete else "–"
        rows.append([group, verdict, count(f"{key}/count", seen), told, rate])
    none = len(part.interventions) - len(found)
    rows.append([group, "without verdict", count(f"{group}/verdict/none/count", none), "–", "–"])
    return rows


def _by_target(groups: dict[str, Dataset]) -> list[Table]:
    rows: list[list[Cell]] = []
    for group, part in groups.items():
        found = verdicts(part)
        kinds = part.interventions["target_kind"].reindex(found.index)
        phases = part.interventions["phase"].reindex(found.index)
        for (kind, phase), some in found.groupby([kinds, phases]):
            key = f"{group}/verdict/{kind}/{phase}"
            rows.append(
                [group, str(kind), str(phase).replace("_", " ")]
                + [count(f"{key}/{v}", (some == v).sum()) for v in VERDICTS]
            )
    head = ("group", "target", "phase reached", *VERDICTS)
    return [Table(id="verdicts-by-target", title="Verdicts by target and phase", head=head, rows=rows, folded=True)]


def _unknown(data: Dataset) -> list[Table]:
    table = data.interventions
    why = table.loc[table["verdict"] == "unknown", "verdict_reason"].value_counts()
    rows = [[str(reason) or "no reason given", count(f"unknown/{reason}", n)] for reason, n in why.sort_index().items()]
    title = "Why a verdict is unknown"
    return [Table(id="unknown", title=title, head=("reason", "interventions"), rows=rows)] if rows else []


def _bars(group: str, part: Dataset, k: int) -> Figure:
    found = verdicts(part)
    known = found[found != "unknown"]
    shown = [v for v in VERDICTS if v != "unknown"]
    shares = [share("", int((known == v).sum()), len(known), "") for v in shown]
    name = f"verdicts-{k}"
    listed = ", ".join(f"{v} {(known == v).sum()}" for v in shown)
    alt = f"Verdicts of {len(known)} interventions of {group}: {listed}; unknown {len(found) - len(known)}."
    with canvas(2.6) as (figure, axes):
        for y, (verdict, each) in enumerate(zip(shown, shares, strict=True)):
            axes.barh(y, each.value, color=VERDICTS[verdict], height=0.62)
            if each.value == each.value:
                axes.plot([each.low, each.high], [y, y], color=FAINT, lw=1.1)
                axes.text(
                    max(each.high, each.value) + 1.5, y, f"{(known == verdict).sum()}  ({number(each.value, 0)} %)",
                    va="center", color=INK, fontsize=8.5,
                )  # fmt: skip
        top = max((each.high for each in shares if each.high == each.high), default=1.0)
        axes.set(xlabel=f"share of {len(known)} interventions with a known verdict [%]", xlim=(0, top * 1.35))
        axes.set_xticks([t for t in axes.get_xticks() if t <= 100])
        axes.set_yticks(range(len(shown)), shown)
        axes.invert_yaxis()
        axes.grid(axis="y", visible=False)
        drawn = svg(figure, name, alt)
    return Figure(
        id=name,
        title=f"Verdicts: {group}",
        svg=drawn,
        alt=alt,
        note="Bars with their number; thin lines: 95 % (Wilson).",
    )
