"""The page: what was simulated, what to keep in mind, and the sections in order."""

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

import pandas as pd
from jinja2 import DictLoader, Environment, StrictUndefined

from analysis.load import Dataset
from analysis.report import (
    answer,
    ceilings,
    crash_pairs,
    crashes,
    definitions,
    interventions,
    places,
    repeat,
    traffic,
    verdicts,
)
from analysis.report.drawing import SERIES, VERDICTS
from analysis.report.judged import judged
from analysis.report.matching import Match, is_baseline, matches
from analysis.report.parts import Quantity, Section
from analysis.statistics import FEW_SEEDS

__all__ = ["render"]

_TEMPLATE = "report.html.j2"
_MORE_ERRORS = (
    "The scenarios that come with aeb-sumo have far more driver errors than life has. Their crash rates are those of "
    "no real road; what can be compared is one system with another, or with none, in the same traffic."
)


def render(data: Dataset, *, networks: Mapping[str, Path] | None = None, title: str = "") -> str:
    """One self-contained HTML page about some runs; the same input gives the same text.

    Args:
        data: the runs.
        networks: scenario, as in `runs`, -> its .net.xml, for the maps.
        title: of the page; empty for one made of the scenarios and systems.
    """
    groups = data.by_group()
    matched, told = matches(data, groups), judged(data, groups)
    extra = {m.group: [*verdicts.card_lines(m.group, told[m.group]), *traffic.card_lines(m)] for m in matched}
    sections = [
        answer.section(matched, extra, verdicts.figures(told), data),
        crash_pairs.section(matched),
        ceilings.section(data, matched),
        verdicts.section(told),
        traffic.section(data, groups, matched),
        crashes.section(data, groups),
        interventions.section(groups),
        places.section(data, networks or {}),
        definitions.section(verdicts=any(len(some.all) for some in told.values())),
        repeat.section(data, groups),
    ]
    folder = files(__package__)
    source = {_TEMPLATE: (folder / _TEMPLATE).read_text(encoding="utf-8")}
    environment = Environment(
        loader=DictLoader(source), autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    environment.tests["quantity"] = lambda cell: isinstance(cell, Quantity)
    return environment.get_template(_TEMPLATE).render(
        title=title or _title(data, groups),
        facts=_facts(data),
        notices=_notices(data, matched),
        sections=[s for s in sections if isinstance(s, Section)],
        style=(folder / "report.css").read_text(encoding="utf-8"),
        series=len(SERIES),
        verdicts=list(VERDICTS),
    )


def _title(data: Dataset, groups: Mapping[str, Dataset]) -> str:
    systems = [g for g in groups if not is_baseline(g)]
    scenarios = ", ".join(sorted(Path(s).stem for s in data.runs["scenario"].unique()))
    if not systems:
        return f"{scenarios} without AEB"
    return f"{', '.join(systems[:3])}{' and more' if len(systems) > 3 else ''} on {scenarios}"


def _facts(data: Dataset) -> list[tuple[str, str]]:
    """What was simulated, in short."""
    runs = data.runs
    span = (runs["end_s"] - runs["begin_s"]).round(6)
    seeds = sorted(runs["seed"].unique())
    facts = [
        ("scenario", ", ".join(sorted(runs["scenario"].unique()))),
        ("runs", f"{len(runs)}, with {len(seeds)} seed{'s' if len(seeds) != 1 else ''}: {_ranges(seeds)}"),
        ("simulated per run", _values(span, "s")),
        ("step", _values(runs["step_length_s"], "s")),
        ("drivers", ", ".join(sorted(runs["drivers"].unique()))),
        ("friction", _values(runs["mu"], "")),
        ("equipped cars", _values(100 * runs.loc[runs["strategy"] != "none", "penetration"], "%") or "none"),
        ("vehicle-km", f"{data.exposure['distance_m'].sum() / 1000:,.0f}".replace(",", " ")),
    ]
    return [(name, value) for name, value in facts if value]


def _values(values: pd.Series, unit: str) -> str:
    known = sorted(values.dropna().unique())
    shown = f"{known[0]:g} to {known[-1]:g}" if len(known) > 4 else ", ".join(f"{v:g}" for v in known)
    return f"{shown} {unit}".strip() if known else ""


def _ranges(numbers: list[int]) -> str:
    """Runs of numbers in short: 1-4, 7."""
    parts: list[list[int]] = []
    for number in numbers:
        if parts and number == parts[-1][-1] + 1:
            parts[-1].append(number)
        else:
            parts.append([number])
    return ", ".join(f"{p[0]}–{p[-1]}" if len(p) > 1 else str(p[0]) for p in parts)


def _notices(data: Dataset, matched: list[Match]) -> list[str]:
    """What a reader must know before believing a number."""
    runs, notices = data.runs, []
    for outcome, what in (("interrupted", "interrupted by the user"), ("failed", "given up by SUMO")):
        some = runs[runs["outcome"] == outcome]
        if len(some):
            reasons = "; ".join(sorted(set(some["reason"]) - {""}))
            notices.append(
                f"{len(some)} of {len(runs)} runs {'was' if len(some) == 1 else 'were'} {what}"
                f"{f' ({reasons})' if reasons else ''}: what was simulated until then counts in tables and figures, "
                "but not in comparisons with the baseline."
            )
    if count := len(data.died):
        reasons = "; ".join(sorted(set(data.died["reason"]) - {""}))
        notices.append(
            f"{count} run{'s' if count > 1 else ''} died or hung{f' ({reasons})' if reasons else ''} and left nothing, "
            "so nothing here counts them."
        )
    for match in matched:
        if not len(match.pairs):
            notices.append(f"{match.group}: no completed baseline run of the same seed, settings and time span, so "
                           "nothing can be said of what it changed.")  # fmt: skip
        elif match.left_out:
            notices.append(f"{match.group}: {len(match.left_out)} of its runs without a completed counterpart are left "
                           "out of comparisons.")  # fmt: skip
    used = {run for match in matched for run in match.pairs["baseline"]}
    alone = runs.loc[(runs["strategy"] == "none") & (runs["outcome"] == "completed"), "run_id"]
    if used and (count := int((~alone.isin(used)).sum())):
        notices.append(f"{count} baseline run{'s' if count > 1 else ''} without a counterpart with AEB: in the figures "
                       "and tables of crashes and traffic, but not in comparisons.")  # fmt: skip
    if matched and max(len(m.pairs) for m in matched) == 1:
        notices.append("One seed: how much the numbers would move with another one is unknown, so comparisons have no "
                       "interval.")  # fmt: skip
    elif matched and max(len(m.pairs) for m in matched) < FEW_SEEDS:
        notices.append("Few seeds: with fewer than six, intervals may be too narrow, as crashes come in clusters.")
    if violations := int(runs["override_violations"].sum()):
        notices.append(
            f"SUMO did not execute {violations} of {int(runs['override_commands'].sum())} commanded speeds exactly."
        )
    if not all(Path(s).suffix for s in runs["scenario"]):
        notices.append(_MORE_ERRORS)
    return notices
