"""What would have happened without: the verdicts of the interventions."""

from collections.abc import Mapping

import numpy as np

from analysis.report.drawing import INK, VERDICTS, canvas, empty, svg
from analysis.report.judged import Judged
from analysis.report.parts import Cell, Figure, Quantity, Section, Table, Text, count, number
from analysis.shares import proportion

__all__ = ["card_lines", "figures", "section"]

_TITLE = "Was it needed? Verdicts"


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
        id="verdict-table", title="Verdicts", head=("group", "verdict", "interventions", "share", "per 1 000 km"),
        rows=[row for name, some in groups.items() for row in _rows(name, some)],
        note="Share of the interventions with a known verdict; the seed is the cluster, as those of one pile-up depend "
        "on each other (of one seed alone: Wilson's interval). Rate over the distance of the equipped vehicles with "
        "the exact Poisson interval, which takes interventions as independent; where only a sample has verdicts, over "
        "the distance that it stands for.",
    )  # fmt: skip
    text = (
        "When an intervention first acted on the world, because the brake bit or the driver heeded the warning, the "
        "simulated world was forked. In the fork this one intervention was suppressed, all else being equal, and the "
        "verdict compares the two. An intervention that never acted is compared with itself.",
    )
    return Section(
        id="verdicts",
        title=_TITLE,
        text=[text],
        tables=[table, _quality(groups), _by_target(groups), *_unknown(groups)],
    )


def _rows(group: str, some: Judged) -> list[list[Cell]]:
    rows: list[list[Cell]] = []
    for verdict in VERDICTS:
        key, seen = f"{group}/verdict/{verdict}", some.count(verdict)
        told: Cell = "–" if verdict == "unknown" else some.share(f"{key}/share", verdict)
        rate: Cell = "–"
        if row := some.rates.get(verdict):
            rate = Quantity(
                key=f"{key}/rate", value=row["per_1000_km"], low=row["low"], high=row["high"], n=some.km,
                of="" if some.without else "km",
            )  # fmt: skip
        rows.append([group, verdict, count(f"{key}/count", seen), told, rate])
    rows.append([group, "no verdict asked for", count(f"{group}/verdict/none/count", some.without), "–", "–"])
    return rows


def _quality(groups: Mapping[str, Judged]) -> Table:
    rows: list[list[Cell]] = []
    for group, some in groups.items():
        if some.quality is not None:
            row, key, known = some.quality, f"{group}/quality", len(some.known)
            seen = {"precision": row["useful"], "precautionary": row["useful"] + row["precautionary"]}
            seen |= {"hard": sum(r["hard"] for r in some.passed_on)}
            precision, sure, hard = (_share(f"{key}/{name}", n, known, "verdicts") for name, n in seen.items())
            right = some.count("avoided")
            recall: Cell = "–"
            if not np.isnan(row["struck"]):
                recall = _share(f"{key}/recall", right, right + int(row["struck"]), "crashes")
            rows.append([group, precision, sure, recall, hard])
    return Table(
        id="quality", title="Precision and recall", rows=rows,
        head=("group", "precision", "with precautionary ones", "recall", "hard braking passed on"),
        note="Wilson's intervals, which take events as independent. Hard braking passed on: interventions with which a "
        "follower brakes above 0.5 g, and without which none does. Recall is unknown where only a sample is judged.",
    )  # fmt: skip


def _share(key: str, seen: int, n: int, of: str) -> Quantity:
    if not n:
        return Quantity(key=key, value=np.nan, of=of, unit="%")
    found = proportion(seen, n)
    return Quantity(key=key, value=100 * found.share, low=100 * found.low, high=100 * found.high, n=n, of=of, unit="%")


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
    one = some.known["seed"].nunique() == 1
    note = f"Thin lines: 95 %, {'of one seed alone, taken as independent' if one else 'by seed'}."
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
    return Figure(id=name, title=f"Verdicts: {group}", svg=drawn, alt=alt, note=note)
