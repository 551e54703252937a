import math

import pandas as pd
import pytest

from aeb_sumo.ncap import GRID, Cell, Outcome, assess, label, points


def result(impact=math.nan, warning=2.5, gap=1.0, peak=8.0):
    return Outcome(impact_speed_kmh=impact, warning_ttc=warning, min_gap=gap, peak_decel=peak)


def rows(*pairs):
    return pd.DataFrame([assess(cell, each) | {"error": "" if each else "SUMO gave up"} for cell, each in pairs])


def test_the_grid_is_lines_of_rising_speeds_without_repeats():
    assert len(set(GRID)) == len(GRID)
    lines = [label(c.case, c.overlap) for c in GRID]
    assert list(dict.fromkeys(lines)) == [
        "CCRs 100 %",
        "CCRs 50 %",
        "CCRm 100 %",
        "CCRm 50 %",
        "CCRb 100 %",
        "left turn",
    ]
    for line in set(lines):
        speeds = [c.test_speed_kmh for c, own in zip(GRID, lines, strict=True) if own == line]
        assert speeds == sorted(speeds)
    assert all(c.test_speed_kmh > c.target_speed_kmh for c in GRID if c.case in ("ccrs", "ccrm"))


@pytest.mark.parametrize("cell", GRID, ids=lambda c: f"{label(c.case, c.overlap)} {c.test_speed_kmh}")
def test_an_avoided_test_has_full_marks_wherever_there_are_any(cell):
    row = assess(cell, result())
    assert (row["contact"], row["euroncap_colour"], row["euroncap_score"]) == (False, "green", 1.0)
    assert math.isnan(row["cncap_score"]) == (cell.case in ("ccrb", "left_turn"))
    assert math.isnan(row["cncap_score"]) or row["cncap_score"] == 1.0
    assert row["r152_passed"] is pd.NA or row["r152_passed"] is True
    assert (row["windows_passed"] is pd.NA) == (cell.case != "ccrm")


@pytest.mark.parametrize(
    ("cell", "impact", "colour", "cncap", "r152"),
    [
        (Cell("ccrs", 1.0, 20), 0.5, "red", 0.975, False),
        (Cell("ccrs", 1.0, 40), 10.0, "orange", 0.75, False),
        (Cell("ccrs", 1.0, 60), 35.0, "red", 25 / 60, True),
        (Cell("ccrs", 1.0, 70), 10.0, "yellow", 60 / 70, pd.NA),  # R152 ends at 60 km/h
        (Cell("ccrs", 0.5, 60), 10.0, "yellow", 50 / 60, pd.NA),  # and at an offset of 0.2 m
        (Cell("ccrm", 1.0, 50), 30.0, "brown", 0.0, False),  # the bands go by the car's speed, C-NCAP by the relative
        (Cell("ccrm", 1.0, 80), 35.0, "red", 25 / 60, True),
        (Cell("ccrb", 1.0, 50), 15.0, "orange", math.nan, pd.NA),
        (Cell("left_turn", 1.0, 30), 5.0, "red", math.nan, pd.NA),  # 30 km/h in CCRs: brown
    ],
)
def test_which_speed_each_protocol_takes(cell, impact, colour, cncap, r152):
    row = assess(cell, result(impact, gap=0.0))
    assert row["contact"] is True
    assert row["euroncap_colour"] == colour
    assert row["cncap_score"] == pytest.approx(cncap, nan_ok=True)
    assert row["r152_passed"] is r152


def test_windows_need_all_three():
    cell = Cell("ccrm", 1.0, 40)
    assert assess(cell, result())["windows_passed"] is True
    for wrong in (result(warning=1.9), result(warning=math.nan), result(gap=2.1), result(peak=10.1)):
        assert assess(cell, wrong)["windows_passed"] is False


def test_points_per_line_and_of_all():
    table = points(
        rows(
            (Cell("ccrs", 1.0, 40), result(10.0)),
            (Cell("ccrs", 1.0, 80), result(80.0)),  # outside C-NCAP's speeds, above R152's
            (Cell("ccrm", 0.5, 40), result()),
            (Cell("left_turn", 1.0, 10), result(3.0)),
        )
    )
    assert table.index.tolist() == ["CCRs 100 %", "CCRm 50 %", "left turn", "all"]
    assert table["cells"].tolist() == [2, 1, 1, 4]
    assert table["euroncap_percent"].tolist() == [25.0, 100.0, 0.0, 37.5]
    assert table["cncap_percent"].tolist() == pytest.approx([75.0, 100.0, math.nan, 87.5], nan_ok=True)
    assert table["r152_passed"].tolist() == [0, 0, 0, 0]
    assert table["r152_cells"].tolist() == [1, 0, 0, 1]
    assert table["windows_passed"].tolist() == [0, 1, 0, 1]
    assert table["windows_cells"].tolist() == [0, 1, 0, 1]


def test_a_test_that_failed_counts_for_nothing():
    table = points(rows((Cell("ccrs", 1.0, 40), None), (Cell("ccrs", 1.0, 30), result())))
    assert table.loc["all", "cells"] == 1
    assert table.loc["all", "euroncap_percent"] == 100
    assert table.loc["all", "r152_cells"] == 1
