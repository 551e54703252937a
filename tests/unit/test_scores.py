import numpy as np
import pytest

from aeb_sumo.scores import (
    Colour,
    ccrm_windows,
    cncap_score,
    euroncap_colour,
    euroncap_score,
    r152_max_impact_speed_kmh,
    r152_passes,
)

# shared/seeds.md 3.1, Table 2 of the comparison of cars M and N, CCRm 40/20 km/h: five runs of car and overlap,
# warning TTC [s], smallest gap [m], largest deceleration [m/s2]; below, their printed means and standard deviations.
TABLE_2 = {
    "M 100 %": [(2.57, 0.98, 9.53), (2.55, 1.01, 9.47), (2.55, 0.96, 9.44), (2.56, 0.94, 9.61), (2.57, 0.97, 9.45)],
    "N 100 %": [(2.64, 1.14, 9.28), (2.63, 1.11, 9.40), (2.61, 1.08, 9.36), (2.64, 1.06, 9.41), (2.62, 1.12, 9.27)],
    "M 50 %": [(1.75, 0.25, 10.71), (1.73, 0.18, 10.69), (1.75, 0.22, 10.78), (1.75, 0.17, 10.62), (1.74, 0.20, 10.76)],
    "N 50 %": [(2.53, 0.98, 9.42), (2.52, 1.06, 9.51), (2.52, 1.01, 9.54), (2.53, 0.95, 9.40), (2.51, 1.04, 9.57)],
}
MEANS = {
    "M 100 %": [(2.560, 0.010), (0.972, 0.026), (9.500, 0.071)],
    "N 100 %": [(2.628, 0.013), (1.102, 0.032), (9.344, 0.066)],
    "M 50 %": [(1.744, 0.009), (0.204, 0.032), (10.712, 0.063)],
    "N 50 %": [(2.522, 0.008), (1.008, 0.044), (9.488, 0.075)],
}


def runs(group):
    return dict(zip(("warning_ttc", "min_gap", "max_decel"), np.array(TABLE_2[group]).T, strict=True))


@pytest.mark.parametrize("group", TABLE_2)
def test_window_verdicts_of_all_20_runs(group):
    """F2: radar alone at 50 % overlap fails all three, everything else passes all."""
    verdict = ccrm_windows(**runs(group))
    expected = [group != "M 50 %"] * 5
    assert verdict.warning_ttc.tolist() == expected
    assert verdict.min_gap.tolist() == expected
    assert verdict.max_decel.tolist() == expected
    assert verdict.passed.tolist() == expected


@pytest.mark.parametrize("group", TABLE_2)
def test_means_of_the_runs(group):
    """F1, arithmetic of the table."""
    for values, (mean, sd) in zip(runs(group).values(), MEANS[group], strict=True):
        assert values.mean() == pytest.approx(mean, abs=5e-4)
        assert values.std(ddof=1) == pytest.approx(sd, abs=5e-4)


def test_distance_at_the_warning():
    """F3: 1.75 s at a closing speed of 20 km/h are 9.72 m; the printed 14.58 m take 30 km/h."""
    warning_ttc = runs("M 50 %")["warning_ttc"].max()
    assert warning_ttc * 20 / 3.6 == pytest.approx(9.72, abs=0.005)
    assert warning_ttc * 30 / 3.6 == pytest.approx(14.58, abs=0.005)


def test_windows_include_their_ends_and_fail_the_unknown():
    ends = ccrm_windows(warning_ttc=[2.0, 4.0, 4.1], min_gap=[0.6, 2.0, 2.1], max_decel=[10.0, 0.0, 10.1])
    assert ends.passed.tolist() == [True, True, False]
    assert not ccrm_windows(warning_ttc=np.nan, min_gap=1.0, max_decel=9.0).passed


@pytest.mark.parametrize(
    ("test", "impact", "expected"),
    [(40, np.nan, 1.0), (40, 0, 1.0), (40, 10, 0.75), (20, 15, 0.25), (20, 20, 0.0), (20, 22, 0.0)],
)
def test_cncap(test, impact, expected):
    assert cncap_score(test_speed=test, impact_speed=impact) == expected


@pytest.mark.parametrize(
    ("test", "impact", "score"),
    [
        *[(test, impact, 1.0) for test in (10, 20, 30, 40, 50, 80) for impact in (np.nan, 0)],
        (10, 0.1, 0.0), (20, 5, 0.0), (30, 10, 0.25), (30, 10.1, 0.0), (40, 10, 0.5), (40, 20, 0.25), (40, 20.1, 0.0),
        (50, 10, 0.75), (50, 20, 0.5), (50, 30, 0.25), (50, 30.1, 0.0), (80, 10, 0.75), (80, 30.1, 0.0),
        (25, 5, 0.0), (45, 5, 0.5),
    ],
)  # fmt: skip
def test_euroncap(test, impact, score):
    assert euroncap_score(euroncap_colour(test_speed_kmh=test, impact_speed_kmh=impact)) == score


def test_euroncap_colours_and_avoidance_only():
    impact = np.array([0, 5, 15, 25, 35])
    assert euroncap_colour(test_speed_kmh=60, impact_speed_kmh=impact).tolist() == list(Colour)
    turning = euroncap_colour(test_speed_kmh=60, impact_speed_kmh=impact, avoidance_only=True)
    assert turning.tolist() == [Colour.GREEN] + [Colour.RED] * 4


def test_r152():
    speeds = [10, 20, 40, 42, 45, 50, 55, 60]
    assert r152_max_impact_speed_kmh(speeds).tolist() == [0, 0, 0, 10, 15, 25, 30, 35]
    assert r152_max_impact_speed_kmh(53) == 30
    assert np.isnan(r152_max_impact_speed_kmh(60.1))
    passes = r152_passes(test_speed_kmh=[40, 40, 42, 42, 60, 61], impact_speed_kmh=[np.nan, 0.1, 10, 10.1, 35, 0])
    assert passes.tolist() == [True, False, True, False, True, False]
