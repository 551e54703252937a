"""The arithmetic of the bench, and the copied highway."""

from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import pytest

from aeb_sumo import scenarios
from aeb_sumo.bench import Line, Measured, Plan, Side
from aeb_sumo.bench.copies import DISTANCE, side_by_side
from aeb_sumo.bench.measure import Stretch


def side(*cpu: float, vehicles: int = 100, steps: int = 10, memory: int = 50_000_000) -> Side:
    measured = [Measured(cpu=c, steps=steps, vehicle_steps=vehicles * steps, memory=memory) for c in cpu]
    return Side(tuple(measured), step_length=0.1)


def line(bare: Side, equipped: Side) -> Line:
    return Line(scenario="s", asked=100, strategy="none", begin=300.0, sumo="1", bare=bare, equipped=equipped)


def test_the_ratio_is_the_median_of_pairs_not_the_ratio_of_medians():
    ratio = line(side(1.0, 2.0, 4.0), side(3.0, 2.0, 8.0)).ratio
    assert [ratio.median, ratio.low, ratio.high] == pytest.approx([2.0, 1.0, 3.0])


def test_vehicles_that_are_missing_count_per_vehicle_step_and_not_per_step():
    one = line(side(1.0, vehicles=100), side(1.5, vehicles=50))
    assert one.ratio.median == pytest.approx(1.5)
    assert one.ratio_per_vehicle.median == pytest.approx(3.0)


def test_a_side_in_units_of_people():
    one = side(0.002, vehicles=100, steps=10, memory=187_000_000)
    assert one.vehicles == 100
    assert one.microseconds.median == pytest.approx(2.0)
    # 1000 vehicle-steps of 0.1 s are 100 vehicle-seconds, in 2 ms.
    assert one.hours_per_hour == pytest.approx(50_000)
    assert one.memory == pytest.approx(187)


@pytest.mark.parametrize(("steps", "turns"), [(20, [20]), (100, [100]), (250, [100, 100, 50])])
def test_turns_add_up_to_the_steps(steps, turns):
    stretch = Stretch(scenario=scenarios.load("track"), begin=0.0, step_length=0.1, steps=steps, sumo="")
    assert stretch.turns == turns
    assert stretch.settling == 100


def test_a_plan_knows_how_many_parts_it_has():
    plan = Plan(
        scenario=scenarios.load("highway"),
        vehicles=(10, 20),
        strategies=("none", "staged"),
        step_lengths=(0.1,),
        repeat=3,
    )
    assert plan.parts == 2 * (1 + 2 * 3)


def files(copies: int, folder: Path) -> tuple[ElementTree.Element, ElementTree.Element]:
    options = list(side_by_side(scenarios.load("highway"), copies, folder).options)
    net, routes = (options[options.index(option) + 1] for option in ("--net-file", "--route-files"))
    return ElementTree.parse(net).getroot(), ElementTree.parse(routes).getroot()


def test_copies_have_all_parts_and_no_id_twice(tmp_path):
    (tmp_path / "one").mkdir()
    alone, copied = files(1, tmp_path / "one"), files(3, tmp_path)
    for one, three in zip(alone, copied, strict=True):
        counts, expected = (Counter(e.tag for e in root.iter()) for root in (three, one))
        shared = {one.tag, "location", "vType"}
        assert counts == {tag: n if tag in shared else 3 * n for tag, n in expected.items()}
        for kind in ("edge", "lane", "junction", "vType", "route", "flow"):
            ids = [e.attrib["id"] for e in three.iter(kind)]
            assert len(ids) == len({*ids})


def test_copies_refer_to_their_own_parts_only(tmp_path):
    net, routes = files(2, tmp_path)
    edges = {e.attrib["id"] for e in net.iter("edge")}
    lanes = {e.attrib["id"] for e in net.iter("lane")}
    for connection in net.iter("connection"):
        ends = [connection.attrib["from"], connection.attrib["to"]]
        assert {*ends} <= edges
        assert len({end.lstrip(":").partition("/")[0] for end in ends}) == 1
        assert connection.get("via") is None or connection.attrib["via"] in lanes
    for junction in net.iter("junction"):
        assert {*junction.attrib["incLanes"].split(), *junction.attrib["intLanes"].split()} <= lanes
    known = {route.attrib["id"] for route in routes.iter("route")}
    assert all({*route.attrib["edges"].split()} <= edges for route in routes.iter("route"))
    assert {flow.attrib["route"] for flow in routes.iter("flow")} == known


def test_copies_are_the_same_elsewhere(tmp_path):
    net, _ = files(2, tmp_path)
    shapes = {lane.attrib["id"]: lane.attrib["shape"] for lane in net.iter("lane")}
    lengths = {lane.attrib["id"]: lane.attrib["length"] for lane in net.iter("lane")}
    for name, shape in shapes.items():
        if name.lstrip(":").startswith("0/"):
            other = name.replace("0/", "1/", 1)
            assert lengths[other] == lengths[name]
            first, second = ([tuple(map(float, p.split(","))) for p in s.split()] for s in (shape, shapes[other]))
            assert [(x, round(y + DISTANCE, 2)) for x, y in first] == second
