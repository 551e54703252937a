"""Rows D1 to D6: Zheng et al. 2020. Its inputs are lost: classes, rules and membership functions are synthetic."""

from aeb_sumo.drive import Case
from aeb_sumo.drivers.classes import CLASSES
from aeb_sumo.reproduction import figures
from aeb_sumo.reproduction.rows import Row, Verdict, agrees, listed, within
from aeb_sumo.reproduction.system import Drives, System
from aeb_sumo.scenarios.cases import approach
from aeb_sumo.strategies.zheng2020 import Zheng2020
from aeb_sumo.units import KMH

__all__ = ["SYSTEM"]

R, C, I, L = Verdict.R, Verdict.C, Verdict.I, Verdict.L  # noqa: E741

SPEEDS = (20, 30, 40)  # km/h
_GAP = 30.44  # m: A28, exact from the printed instants


def _name(driver: int, speed: int) -> str:
    return f"class {driver}, CCRs {speed}"


def cases() -> dict[str, Case]:
    """CCRs 20, 30 and 40 for each class of drivers."""
    return {
        _name(driver, speed): Case(
            scenario=approach(_name(driver, speed), ego=speed * KMH, lead=0.0, gap=_GAP, step_length=0.01),
            strategy=Zheng2020(driver_class=driver),
        )
        for driver in range(1, CLASSES + 1)
        for speed in SPEEDS
    }


def rows(drives: Drives) -> list[Row]:
    """The truth table."""
    first = drives[_name(1, 20)]
    gaps = [d.final_gap for d in drives.values()]
    peaks = [d.peak for d in drives.values()]
    rules = "calibrated: synthetic rules and membership functions"
    start = "exact, that is to a step of 0.01 s; the start, 30.44 m, follows from both instants"
    return [
        within("D1", "class 1, CCRs 20: warning", "s", 2.48, first.warn_time, 0.01, R, start),
        within("D1", "class 1, CCRs 20: braking", "s", 3.98, first.at(first.time, first.triggered), 0.01, R, start),
        listed(
            "D2", "class 1, CCRs 20: from warning to braking", "s", 1.5, first.warning_length, I,
            "2 T and T + 0.2 s are 1.3 s apart; read as T + 0.2 = 1.5 s and 2 (T + 0.2) = 3.0 s",
        ),
        within("D3", "class 1, CCRs 20: braking until it stands", "s", 2.60, first.brake_length, 0.1, C, rules),
        within("D3", "class 1, CCRs 20: largest deceleration", "m/s2", 3.0, first.peak, 0.3, C, rules),
        agrees(
            "D4", "final gaps, 4 classes, 20 to 40 km/h", "0.8 to 2.8 m", f"{min(gaps):.2f} to {max(gaps):.2f} m", C,
            good=min(gaps) >= 0.7 and max(gaps) <= 2.9, note=rules + "; tolerance 0.1 m",
        ),
        agrees(
            "D4", "largest decelerations", "1 to 7 m/s2", f"{min(peaks):.2f} to {max(peaks):.2f} m/s2", C,
            good=min(peaks) >= 0.9 and max(peaks) <= 7.1, note=rules + "; tolerance 0.1 m/s2",
        ),
        agrees("D4", "contacts", "none", "some" if any(d.crashed for d in drives.values()) else "none", C),
        listed("D5", "T_1 to T_4, Tables 1 to 5, R2", "", "lost", "synthetic", L, "zheng2020_synthetic.csv"),
        listed("D6", "least gap", "", "1.4 to 2.5 m", "0.8 to 2.8 m", I, "the results leave the range of the design"),
    ]  # fmt: skip


def _figures(drives: Drives) -> "dict[str, figures.Figure]":
    """Figures 10 and 11."""
    classes = {f"class {k}": drives[_name(k, 20)] for k in range(1, CLASSES + 1)}
    speeds = {f"{v} km/h": drives[_name(4, v)] for v in SPEEDS}
    return {
        "figure_10_classes": figures.approach("CCRs 20, four classes of drivers", classes),
        "figure_11_class_4": figures.approach("Class 4, CCRs 20, 30, 40", speeds),
    }


SYSTEM = System(name="zheng2020", source=Zheng2020.source, cases=cases, rows=rows, figures=_figures)
