import re

import pytest

from aeb_sumo import strategies
from aeb_sumo.equipment import Equipment, Share, System, equipment
from aeb_sumo.errors import InputError


def carried(text, vclass="passenger", vtype="car", n=400):
    """Names of the systems that cars 0 to n - 1 of some type carry."""
    mix = Equipment.parse(text)
    systems = [mix.of(str(k), vtype=vtype, vclass=vclass, seed=1) for k in range(n)]
    return [s.name if s else "" for s in systems]


def test_the_canonical_text_is_sorted_and_short():
    mix = Equipment.parse(" zhao2025 = 0.30, truck:zhao2025/radar=1.0 ,yan2025/fusion=0.2")
    assert mix.text == mix.name == "yan2025=0.2,zhao2025=0.3,truck:zhao2025/radar=1"
    assert [s.name for s in mix.systems] == ["yan2025", "zhao2025", "zhao2025/radar"]


def test_one_system_in_cars_goes_by_its_own_name():
    mix = Equipment.parse("zhao2025/radar=0.3")
    assert (mix.name, mix.sensing, mix.penetration) == ("zhao2025", "radar", 0.3)
    assert mix == Equipment.single("zhao2025", "radar", penetration=0.3)
    assert mix.run_id("w0", 7) == "w0-zhao2025_radar-p0.3-s7"


def test_the_baseline_is_no_equipment():
    none = Equipment.single("none")
    assert none == Equipment()
    assert (none.name, none.sensing, none.parameters, none.penetration, none.systems) == ("none", "", "", 0.0, ())


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("zhao2025=1,taxi:yan2025=1,cab:lin2021=1", "lin2021"),
        ("zhao2025=1,taxi:yan2025=1,van:lin2021=1", "yan2025"),
        ("zhao2025=1,truck:yan2025=1", "zhao2025"),
        ("zhao2025=1,cab:zhao2025=0", ""),
    ],
)
def test_type_goes_before_class_and_class_before_all_cars(text, expected):
    assert set(carried(text, vclass="taxi", vtype="cab", n=5)) == {expected}


@pytest.mark.parametrize("vclass", ["truck", "bus", "bicycle", "pedestrian"])
def test_only_cars_are_equipped_unless_another_kind_is_named(vclass):
    assert set(carried("zhao2025=1", vclass=vclass, n=5)) == {""}
    assert set(carried(f"{vclass}:zhao2025=1", vclass=vclass, n=5)) == {"zhao2025"}
    assert set(carried(f"{vclass}:zhao2025=1", n=5)) == {""}


def test_a_mix_of_kinds_has_no_one_penetration():
    assert str(Equipment.parse("zhao2025=1,truck:zhao2025=0.5").penetration) == "nan"
    assert Equipment.parse("zhao2025=0.25,yan2025=0.5").penetration == 0.75


def test_parameters_go_to_the_system_they_name():
    mix = Equipment.parse(
        "zhao2025=0.3,zhao2025/radar=0.3,yan2025=0.2",
        {"zhao2025": {"comfort_decel": 4.0, "brake": {"lag": 0.3}}, "zhao2025.comfort_decel": 5},
    )
    for k in (1, 2):
        assert mix.systems[k].strategy.comfort_decel == 5
        assert mix.systems[k].strategy.brake.lag == 0.3
    assert mix.parameters.split()[0] == "zhao2025.brake.lag=0.3"
    assert mix.systems[0].strategy == strategies.load("yan2025")


def test_runs_of_different_equipment_have_different_file_names():
    mixes = [
        Equipment(),
        Equipment.single("zhao2025"),
        Equipment.single("zhao2025", "radar"),
        Equipment.single("zhao2025", penetration=0.5),
        Equipment.single(strategies.load("zhao2025", {"comfort_decel": 5.0})),
        Equipment.parse("zhao2025=0.5,yan2025=0.5"),
        Equipment.parse("zhao2025=0.5,yan2025=0.5", {"zhao2025.comfort_decel": 5.0}),
        Equipment.parse("a:zhao2025=0.5"),
        Equipment.parse("a_zhao2025:zhao2025=0.5"),
        Equipment.parse("ä:zhao2025=0.5"),
        Equipment.parse("ö:zhao2025=0.5"),
        *(Equipment.parse("x" * 200 + f"{k}:zhao2025=0.5") for k in range(2)),
    ]
    ids = [mix.run_id("city", 1) for mix in mixes]
    assert len(set(ids)) == len(ids)
    for name in ids:
        assert re.fullmatch(r"[A-Za-z0-9._-]{1,150}", name), name


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("zhao2025=0.6,yan2025=0.5", ["cars", "at most", "1.1"]),
        ("bus:zhao2025=0.6,bus:yan2025=0.5", ["bus", "1.1"]),
        ("zhao2025=nan", ["zhao2025", "0..1"]),
        ("bus:zhao2025=-0.1", ["bus:zhao2025", "0..1", "-0.1"]),
        ("zhao2025=0.1,zhao2025/ideal=0.1", ["zhao2025", "twice"]),
        ("none=0.5", ["none", "nobody"]),
        ("", ["SYSTEM", "SHARE"]),
        ("zhao2025=0.5,", ["SYSTEM", "SHARE"]),
        (":zhao2025=0.5", [":zhao2025=0.5", "KIND"]),
        ("zhao2025/=0.5", ["zhao2025/=0.5", "SUITE"]),
    ],
)
def test_bad_text(text, words):
    with pytest.raises(InputError) as error:
        Equipment.parse(text)
    for word in words:
        assert word in str(error.value)


def test_shares_that_add_up_to_1_but_for_rounding():
    assert set(carried("zhao2025=0.1,yan2025=0.2,lin2021=0.7")) == {"zhao2025", "yan2025", "lin2021"}


def test_a_kind_that_does_not_exist():
    mix = Equipment.parse("zhao2025=1,taxi:yan2025=1,cab:lin2021=1")
    mix.check_kinds({"cab", "DEFAULT_VEHTYPE"})
    with pytest.raises(InputError, match=r"'cab'.* types: car$"):
        mix.check_kinds({"car", "DEFAULT_VEHTYPE"})


def test_two_systems_of_one_name_are_refused():
    shares = [
        Share(kind=kind, system=System.of(strategies.load("zhao2025", {"comfort_decel": decel})), share=1.0)
        for kind, decel in (("bus", 4.0), ("truck", 5.0))
    ]
    with pytest.raises(InputError, match="told apart"):
        Equipment(tuple(shares))


def test_equip_excludes_the_arguments_it_replaces():
    for given in ({"strategy": "zhao2025"}, {"sensing": "radar"}, {"penetration": 1.0}):
        with pytest.raises(InputError, match="excludes " + next(iter(given))):
            equipment(**given, equip="zhao2025=1")


@pytest.mark.parametrize("parameters", [{"brake.lag": 0.1}, {"lin2021.x": 1}, {"zhao2025": 3}, {"comfort_decel": 5}])
def test_a_parameter_names_its_system(parameters):
    with pytest.raises(InputError, match=f"'{next(iter(parameters))}'.*here: zhao2025$"):
        Equipment.parse("zhao2025=1", parameters)
