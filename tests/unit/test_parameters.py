from dataclasses import dataclass, field, replace

import pytest

from aeb_sumo import strategies
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, differences, parse, read_file, within
from aeb_sumo.perception.suites import RADAR, SUITES
from aeb_sumo.scenarios.cases import approach
from aeb_sumo.vehicle.car import Car
from aeb_sumo.vehicle.friction import FrictionParams
from aeb_sumo.vehicle.tyre import Tyre


@dataclass(frozen=True)
class Some:
    ratio: float = within(0.5, 0.0, 1.0)
    count: int = 2
    on: bool = True
    name: str = "a"
    inner: tuple[int, ...] = field(default=())


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"ratio": 1.5}, r"Some.ratio must be within 0 .. 1, not 1.5"),
        ({"ratio": float("nan")}, r"Some.ratio must be within 0 .. 1, not nan"),
        ({"count": -1}, r"Some.count must be a number, 0 or more, not -1"),
    ],
)
def test_numbers_out_of_range_are_named(values, message):
    with pytest.raises(InputError, match=message):
        check(Some(**values))


@pytest.mark.parametrize(
    ("name", "parameters", "message"),
    [
        ("zhao2025", {"comfort_decl": 6}, "has no parameter 'comfort_decl'; there are: brake, reaction_time"),
        ("zhao2025", {"comfort_decel": "hard"}, "Zhao2025.comfort_decel must be a number, not 'hard'"),
        ("zhao2025", {"t2_free": -6}, "Zhao2025.t2_free must be a number, 0 or more, not -6"),
        ("zhao2025", {"brake.lag": -1}, "BrakeParams.lag must be a number, 0 or more, not -1"),
        ("zhao2025", {"brake.dead_time_by_mu": 3}, "dead_time_by_mu must be set in Python, not here"),
        ("zheng2020", {"driver_class": 5}, "driver_class must be within 1 .. 4, not 5"),
        ("zheng2020", {"driver_class": 1.5}, "driver_class must be a whole number, not 1.5"),
        ("zhao2025", {"brake.pid.kp": -1}, "PidParams.kp must be within 0 .. 100, not -1"),
        ("zhao2025", {"brake.pid.ti": 0}, "PidParams.ti must be within 0.001 .. 100, not 0"),
        ("zhao2025", {"comfort_decel": 0}, "Zhao2025.comfort_decel must be within 0.5 .. 12, not 0"),
        ("staged", {"warn_ttc": 0.5}, r"Staged.warn_ttc must not be below brake_ttc"),
        ("yan2025", {"slow": 20.0}, "Yan2025.slow must not exceed fast"),
        ("lin2021_fixed", {"mu": -0.3}, "Lin2021Fixed.mu must be within 0.05 .. 1.5, not -0.3"),
        ("yan2025", {"rule": "or"}, "Yan2025.rule must be one of and, lane_entry, not 'or'"),
    ],
)
def test_bad_parameters_of_a_strategy(name, parameters, message):
    with pytest.raises(InputError, match=message):
        strategies.load(name, parameters)


def test_parameters_reach_their_fields():
    system = strategies.load("zhao2025", parse(("comfort_decel = 5", "brake.lag=0.1")))
    assert system.comfort_decel == 5.0
    assert system.brake.lag == 0.1
    assert differences(system) == "brake.lag=0.1 comfort_decel=5.0"
    assert not differences(strategies.load("zhao2025"))


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Tyre(c_x=-3), "Tyre.c_x must be a number, above 0, not -3"),
        (lambda: Car(mass=0), "Car.mass must be a number, above 0, not 0"),
        (lambda: FrictionParams(period=0.0), "FrictionParams.period must be a number, above 0, not 0"),
        (lambda: replace(RADAR, detect=((1.0, 10.0), (0.5, 5.0))), "Sensor.detect must have rising overlaps"),
        (lambda: replace(SUITES["radar"], cycle=-1.0), "Suite.cycle must be a number, 0 or more, not -1"),
        (lambda: approach("x", ego=10.0, lead=0.0, gap=20.0, mu=-0.3), "friction of x must be within 0.05 .. 1.5"),
        (lambda: approach("x", ego=10.0, lead=0.0, gap=-3.0), "gap of x must be within 0.1 .. 2000, not -3"),
        (lambda: approach("x", ego=10.0, lead=0.0, gap=20.0, overlap=2.0), "overlap of x must be within 0.05 .. 1"),
    ],
)
def test_other_dataclasses_check_their_numbers_too(make, message):
    with pytest.raises(InputError, match=message):
        make()


@pytest.mark.parametrize("text", ["comfort_decel", "=5", "comfort_decel="])
def test_what_is_no_assignment_is_refused(text):
    with pytest.raises(InputError, match="write NAME=VALUE"):
        parse((text,))


def test_a_file_of_parameters(tmp_path):
    path = tmp_path / "tuned.toml"
    path.write_text("comfort_decel = 5\n[brake]\nlag = 0.1\n")
    assert strategies.load("zhao2025", read_file(path)).brake.lag == 0.1


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match=r"cannot read the parameter file .*No such file"):
        read_file(tmp_path / "none.toml")
    (tmp_path / "bad.toml").write_text("a = = b")
    with pytest.raises(InputError, match=r"bad.toml is no TOML"):
        read_file(tmp_path / "bad.toml")
