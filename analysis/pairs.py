"""Crash by crash: what became of every crash of the baseline in the world with AEB, and which crashes are new."""

import numpy as np
import pandas as pd

from aeb_sumo.errors import InputError
from aeb_sumo.severity import SAME_IMPACT
from analysis.load import Dataset

__all__ = ["OUTCOMES", "SAME", "pairs", "partners"]

OUTCOMES = ("avoided", "mitigated", "unchanged", "worsened", "new")
"""What a pair of vehicles can come to; all but `new` are crashes of the baseline, all but `avoided` of the AEB run."""

SAME = (
    *("scenario", "seed", "demand", "ebike_share", "weather", "mu", "drivers", "step_length_s", "blockage_s"),
    *("begin_s", "end_s"),
)
"""What a run and its baseline agree in; a baseline has no AEB, so what is said of the AEB is no difference."""
_WHO = ("kind", "typology", "striker", "struck", "striker_vclass", "struck_vclass")
_OF_EACH = ("crash_id", "time_s", "impact_speed_mps", "serious_risk", "death_risk", "secondary")
_BEFORE, _AFTER = 15.0, 5.0  # s around the baseline's crash, our assumption: an intervention belongs to it


def partners(data: Dataset, baseline: str = "none") -> pd.DataFrame:
    """The baseline run of every other run: the same seed and settings, but for the AEB.

    Args:
        data: the runs.
        baseline: the strategy, or the name of the group of runs, that the others are compared with.

    Returns:
        Columns `run_id`, `baseline_run_id`, `seed`, `group` (of the run), in the order of groups and runs.

    Raises:
        InputError: a run has no partner, or several; or there is no baseline, or nothing beside it.
    """
    groups = data.groups()
    runs = data.runs.assign(group=data.runs["run_id"].map(groups))
    is_baseline = (runs["strategy"] == baseline) | (runs["group"] == baseline)
    others, bases = runs[~is_baseline], runs[is_baseline]
    if bases.empty or others.empty:
        what = "no runs of" if bases.empty else "nothing but runs of"
        raise InputError(f"{what} {baseline!r}, so no pairs; there are {', '.join(sorted(groups.unique()))}")
    keys = list(SAME)
    twins = bases[bases.duplicated(keys, keep=False)]
    if not twins.empty:
        raise InputError(f"more than one baseline run of the same settings: {', '.join(twins['run_id'])}")
    found = others.merge(bases[[*keys, "run_id"]], on=keys, how="left", suffixes=("", "_of_baseline"))
    alone = found[found["run_id_of_baseline"].isna()]
    if not alone.empty:
        raise InputError(f"no run of {baseline!r} with the settings of {_difference(alone.iloc[0], bases)}")
    found = found.rename(columns={"run_id_of_baseline": "baseline_run_id"})
    found = found.sort_values(["group", "seed", "run_id"], kind="stable", ignore_index=True)
    return found[["run_id", "baseline_run_id", "seed", "group"]]


def _difference(run: pd.Series, bases: pd.DataFrame) -> str:
    """A run without a partner, and what no baseline run has of it."""
    missing = [key for key in SAME if str(run[key]) not in set(bases[key].map(str))]
    return f"{run['run_id']}: " + (
        ", ".join(f"{key} {run[key]}" for key in missing) or "each is there, but not together"
    )


def pairs(data: Dataset, baseline: str = "none") -> pd.DataFrame:
    """Every crash of the baseline with what its two vehicles did under AEB, and every new crash.

    The same encounter is the same two vehicles. Which of the two hits the other may change.

    Args:
        data: runs with and without AEB, any number of groups.
        baseline: the strategy, or the name of the group of runs, that the others are compared with.

    Returns:
        One row per crash of the baseline and AEB group, and per new crash: `group`, `seed`, `run_id`,
        `baseline_run_id`; `kind`, `typology`, `striker`, `struck` and their `*_vclass`, of the baseline's crash, or of
        the new one; `crash_id`, `time_s`, `impact_speed_mps`, `serious_risk` and `death_risk` (of both persons
        together, null where no curve applies) and `secondary` under AEB, and the same with `baseline_` before it,
        null where there was no crash; `outcome`; and `how`.

        `outcome`: `avoided` (the two do not crash under AEB); `mitigated`, `unchanged` or `worsened` (they do; by the
        risk of serious injury where a curve applies in both worlds, else by impact speed; within 1 km/h of impact speed
        nothing has changed, as in verdicts); `new` (they crash under AEB alone).

        `how`, of avoided ones: `intervened` (the AEB of one of the two acted, on whomever, beginning between 15 s
        before and 5 s after the baseline's crash, our assumption), else `diverged` (the traffic had become another one,
        by other AEBs or by earlier acts of theirs); else empty.

    Raises:
        InputError: as `partners`.
    """
    of_run = partners(data, baseline)
    crashes = data.crashes.assign(
        serious_risk=_of_both(data.crashes, "serious"), death_risk=_of_both(data.crashes, "death"),
        secondary=data.crashes["secondary"].astype("boolean"), crash_id=data.crashes["crash_id"].astype("Int64"),
        first=data.crashes[["striker", "struck"]].min(axis=1), second=data.crashes[["striker", "struck"]].max(axis=1),
    )  # fmt: skip
    columns = ["first", "second", *_WHO, *_OF_EACH]
    key = ["run_id", "first", "second"]
    there = of_run.merge(crashes[["run_id", *columns]], on="run_id")
    before = of_run.merge(crashes[["run_id", *columns]].rename(columns={"run_id": "baseline_run_id"}))
    both = before.merge(there, on=[*of_run.columns, *key[1:]], how="outer", suffixes=("_0", "_1"), indicator="worlds")
    in_baseline, in_aeb = both["worlds"] != "right_only", both["worlds"] != "left_only"
    rows = both[[*of_run.columns, *key[1:]]].copy()
    for name in _WHO:
        rows[name] = both[f"{name}_0"].where(in_baseline, both[f"{name}_1"])
    for name in _OF_EACH:
        rows[name], rows[f"baseline_{name}"] = both[f"{name}_1"], both[f"{name}_0"]
    change = np.sign(_change(rows)).map({-1.0: "mitigated", 0.0: "unchanged", 1.0: "worsened"})
    rows["outcome"] = change.where(in_baseline & in_aeb, np.where(in_aeb, "new", "avoided")).astype(str)
    acted = _acted(rows, data.read("interventions", ["run_id", "vehicle", "begin_s"]))
    rows["how"] = np.where(rows["outcome"] != "avoided", "", np.where(acted, "intervened", "diverged"))
    rows["order"] = rows["run_id"].map({run: k for k, run in enumerate(of_run["run_id"])})
    rows["when"] = rows["baseline_time_s"].fillna(rows["time_s"])
    rows = rows.sort_values(["order", "when", "first", "second"], kind="stable", ignore_index=True)
    names = ["group", "seed", "run_id", "baseline_run_id", "outcome", "how", *_WHO]
    return rows[[*names, *(f"{world}{name}" for name in _OF_EACH for world in ("baseline_", ""))]]


def _of_both(crashes: pd.DataFrame, what: str) -> pd.Series:
    """Sum of the risks of both persons; null where neither has a curve."""
    return crashes[[f"striker_{what}_risk", f"struck_{what}_risk"]].astype(float).sum(axis=1, min_count=1)


def _change(rows: pd.DataFrame) -> pd.Series:
    """Below 0 for less harm under AEB, above for more, 0 for the same; NaN where one of the worlds has no crash."""
    slower = rows["impact_speed_mps"] - rows["baseline_impact_speed_mps"]
    safer = rows["serious_risk"] - rows["baseline_serious_risk"]
    return safer.where(safer.notna(), slower).where(slower.abs() > SAME_IMPACT, slower * 0.0)


def _acted(rows: pd.DataFrame, interventions: pd.DataFrame) -> pd.Series:
    """Whether an AEB of one of the two acted, on whomever, around the time of the baseline's crash."""
    either = [rows.reset_index(names="row").assign(vehicle=rows[one].to_numpy()) for one in ("first", "second")]
    found = pd.concat(either).merge(interventions, on=["run_id", "vehicle"])
    since = found["begin_s"] - found["baseline_time_s"]
    return pd.Series(rows.index.isin(found.loc[since.between(-_BEFORE, _AFTER), "row"]), index=rows.index)
