"""Verdicts: how many interventions were needed, how many were false, and what they passed on to those behind.

Where a run judged a sample of its interventions only, rates are those of the sample by the share of the distance that
it stands for. Unknown verdicts are counted as such and belong to no rate.
"""

from collections.abc import Sequence

import pandas as pd

from aeb_sumo.criticality import EVASIVE
from aeb_sumo.results import VERDICTS
from analysis.load import Dataset
from analysis.rates import poisson_rate
from analysis.shares import proportion

__all__ = ["passed_on", "precision_recall", "verdict_counts", "verdict_rates"]

_USEFUL = ("avoided", "mitigated")
_HARMFUL = ("induced", "worsened")
_KNOWN = [v for v in VERDICTS if v != "unknown"]
# Column of `interventions` -> that of `crashes` that says the same of a striker with an AEB.
_CRASHES = {
    "strategy": "striker_strategy",
    "target_vclass": "struck_vclass",
    "place": "place",
    "vclass": "striker_vclass",
}


def _place(lanes: pd.Series) -> pd.Series:
    """Place of a lane: `junction ID`, or the id of the edge."""
    edges = lanes.str.replace(r"_\d+$", "", regex=True)
    inside = edges.str.startswith(":")
    return edges.where(~inside, "junction " + edges.str.slice(1).str.replace(r"_\d+$", "", regex=True))


def _judged(part: Dataset, *columns: str | None) -> pd.DataFrame:
    """Some columns, of which None is none, of the interventions with a verdict; `place` is one of them."""
    names = ["verdict", *("lane" if name == "place" else name for name in columns if name is not None)]
    judged = part.read("interventions", names, [("verdict", "in", list(VERDICTS))])
    return judged.assign(place=_place(judged["lane"])) if "place" in columns else judged


def _judged_km(part: Dataset) -> float:
    """Distance driven with an AEB that the verdicts stand for [km]."""
    interventions = part.read("interventions", ["run_id", "verdict"])
    every = interventions["verdict"].isin(VERDICTS).groupby(interventions["run_id"]).mean()
    km = part.exposure[part.exposure["equipped"]].groupby("run_id")["distance_m"].sum() / 1000
    return float((km * every.reindex(km.index).fillna(1.0)).sum())


def verdict_counts(data: Dataset, by: str | None = None) -> pd.DataFrame:
    """Interventions by verdict, one column per group of runs.

    Args:
        data: the runs.
        by: another column of `interventions`, or `place` (junction or edge), to count by as well.
    """
    keys = ["verdict"] if by is None else [by, "verdict"]
    groups = data.by_group()
    counts = pd.DataFrame({name: _judged(part, by).groupby(keys).size() for name, part in groups.items()})
    counts = counts.reindex(columns=list(groups)).fillna(0).astype("int64").rename_axis(columns="group")
    if by is None:
        return counts.reindex(list(VERDICTS), fill_value=0).rename_axis("verdict")
    return counts.sort_index()


def verdict_rates(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Verdicts per 1,000 km of the vehicles with an AEB, with exact Poisson intervals.

    Returns:
        Index (group, verdict), for groups with verdicts; columns `count`, `per_1000_km`, `low`, `high`.
    """
    rows = []
    for name, part in data.by_group().items():
        judged, km = _judged(part), _judged_km(part)
        for verdict in _KNOWN if len(judged) else ():
            count = int((judged["verdict"] == verdict).sum())
            rate = poisson_rate(count, km / 1000, confidence)
            row = {"count": count, "per_1000_km": rate.rate, "low": rate.low, "high": rate.high}
            rows.append({"group": name, "verdict": verdict} | row)
    columns = ["group", "verdict", "count", "per_1000_km", "low", "high"]
    return pd.DataFrame(rows, columns=columns).set_index(["group", "verdict"])


def precision_recall(data: Dataset, by: str | None = None, confidence: float = 0.95) -> pd.DataFrame:
    """How many of the interventions were needed, and how many of the crashes to be avoided were.

    Precision is the share of judged interventions that avoided or mitigated a crash; recall the share avoided of the
    crashes that vehicles with an AEB would have struck: those avoided, and those that they struck all the same. Groups
    that differ in the threshold of a trigger make a curve. Intervals are Wilson's and take interventions as
    independent.

    Args:
        data: the runs.
        by: `target_vclass`, `place`, `strategy`, `vclass`, or another column of `interventions`, for which there is no
            recall, as crashes do not have it.
        confidence: of the intervals, 0 to 1.

    Returns:
        Index group, or (group, by); columns `judged`, `useful` (avoided, mitigated), `precautionary`, `unneeded`,
        `unchanged`, `harmful` (induced, worsened), `unknown`; `precision`, `precision_low`, `precision_high`;
        `precision_precautionary`, that counts precautionary ones as needed; `struck`, crashes with an equipped striker;
        `recall`, `recall_low`, `recall_high`.
    """
    rows = []
    for name, part in data.by_group().items():
        judged = _judged(part, by)
        if judged.empty:
            continue
        struck = part.crashes[part.crashes["striker_equipped"].astype(bool)]
        struck = struck.assign(place=_place(struck["lane"]))
        values = [None] if by is None else sorted({*judged[by], *(struck[_CRASHES[by]] if by in _CRASHES else ())})
        sampled = len(judged) < part.count("interventions")
        for value in values:
            own = judged if by is None else judged[judged[by] == value]
            hit = struck if by is None or by not in _CRASHES else struck[struck[_CRASHES[by]] == value]
            key = {"group": name} | ({} if by is None else {str(by): value})
            countable = not sampled and (by is None or by in _CRASHES)
            rows.append(key | _quality(own["verdict"], len(hit) if countable else None, confidence))
    keys = ["group"] if by is None else ["group", by]
    columns = list(_quality(pd.Series([], dtype=str), None, confidence))
    return pd.DataFrame(rows, columns=[*keys, *columns]).set_index(keys)


def _quality(verdicts: pd.Series, struck: int | None, confidence: float) -> dict[str, float]:
    counts = verdicts.value_counts()

    def count(names: Sequence[str]) -> int:
        return int(counts.reindex(list(names)).fillna(0).sum())

    known, useful = count(_KNOWN), count(_USEFUL)
    precision = proportion(useful, known, confidence)
    avoided = count(["avoided"])
    recall = proportion(avoided if struck is not None else 0, avoided + struck if struck is not None else 0, confidence)
    return {
        "judged": len(verdicts),
        "useful": useful,
        "precautionary": count(["precautionary"]),
        "unneeded": count(["unneeded"]),
        "unchanged": count(["unchanged"]),
        "harmful": count(_HARMFUL),
        "unknown": count(["unknown"]),
        "precision": precision.share,
        "precision_low": precision.low,
        "precision_high": precision.high,
        "precision_precautionary": proportion(useful + count(["precautionary"]), known).share,
        "struck": float("nan") if struck is None else struck,
        "recall": recall.share,
        "recall_low": recall.low,
        "recall_high": recall.high,
    }


def passed_on(data: Dataset, confidence: float = 0.95) -> pd.DataFrame:
    """Hard braking passed on to those behind: followers who brake above 0.5 g with an intervention and not without it.

    Returns:
        Index (group, verdict); columns `judged`, `hard`, `share` with Wilson's interval `low`, `high`.
    """
    rows = []
    for name, part in data.by_group().items():
        judged = _judged(part, "with_follower_decel_mps2", "without_follower_decel_mps2")
        judged = judged[judged["verdict"].isin(_KNOWN)]
        hard = (judged["with_follower_decel_mps2"] > EVASIVE) & ~(judged["without_follower_decel_mps2"] > EVASIVE)
        for verdict in [v for v in _KNOWN if (judged["verdict"] == v).any()]:
            own = hard[judged["verdict"] == verdict]
            share = proportion(int(own.sum()), len(own), confidence)
            row = {
                "judged": len(own),
                "hard": int(own.sum()),
                "share": share.share,
                "low": share.low,
                "high": share.high,
            }
            rows.append({"group": name, "verdict": verdict} | row)
    columns = ["group", "verdict", "judged", "hard", "share", "low", "high"]
    return pd.DataFrame(rows, columns=columns).set_index(["group", "verdict"])
