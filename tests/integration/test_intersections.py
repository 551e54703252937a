"""The networks of the generator in SUMO: offsets, conflicts, and every movement of riders and cars."""

import itertools
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import libsumo
import numpy as np
import pytest

import sumo_nets
from aeb_sumo import scenarios
from aeb_sumo.scenarios.demand import Demand, Rider, routes
from aeb_sumo.simulate import run
from aeb_sumo.world.network import Network
from aeb_sumo.world.session import IMPOSED, Session
from sumo_nets import plain
from sumo_nets.build import convert
from sumo_nets.intersection import Intersection
from tests.integration.test_networks import HAS_NETCONVERT

TYPES = {"w0": 4.8, "w1": 7.9, "w2": 11.7, "w2t": 11.0, "b2": 16.3}
"""Offsets printed in Yan et al. 2025, Table 1 [m]."""

needs_netconvert = pytest.mark.skipif(not HAS_NETCONVERT, reason="netconvert is not installed (extra: dev)")


@contextmanager
def running(net: Path, traffic: str, folder: Path, **options: str) -> Iterator[Session]:
    (folder / "r.rou.xml").write_text(traffic)
    flat = [text for name, value in options.items() for text in (f"--{name.replace('_', '-')}", value)]
    with Session(["-n", str(net), "-r", str(folder / "r.rou.xml"), *IMPOSED, "--step-length", "0.1", *flat]) as session:
        yield session


def net(name: str) -> Path:
    return sumo_nets.folder(name) / f"{name}.net.xml"


def built(intersection: Intersection, folder: Path) -> Path:
    plain.write(intersection, folder, "own")
    return convert(folder, "own")


def ways(network: Network) -> dict[str, tuple[str, str]]:
    """Lane inside the junction -> the lanes before and behind it."""
    lanes = [lane for lane in libsumo.lane.getIDList() if not lane.startswith(":")]
    return {via: (lane, link.to) for lane in lanes for link in network.links(lane) for via in link.via}


def cross(one, two) -> bool:
    """Whether two lines cross, ends apart."""

    def side(a, b, c):
        return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])

    return any(
        side(p, q, r) * side(p, q, s) < -1e-9 and side(r, s, p) * side(r, s, q) < -1e-9
        for p, q in itertools.pairwise(one)
        for r, s in itertools.pairwise(two)
    )


def unseen(network: Network) -> list[tuple[str, str]]:
    """Pairs of lanes that cross in the junction and that SUMO does not know to conflict."""
    origin = ways(network)
    return [
        (origin[a], origin[b])
        for a, b in itertools.combinations(origin, 2)
        if origin[a][0] != origin[b][0]
        and cross(network.shape(a), network.shape(b))
        and b not in network.foes(a)
        and a not in network.foes(b)
    ]


@pytest.mark.parametrize(("name", "offset"), TYPES.items())
def test_the_built_net_has_the_offset_of_table_1(name, offset, tmp_path):
    with running(net(name), "<routes/>", tmp_path):
        lanes = libsumo.edge.getLaneNumber("si")
        car, bike = (libsumo.lane.getShape(lane)[0][0] for lane in (f"si_{lanes - 1}", "so_0"))
    assert abs(car - bike) == pytest.approx(offset, abs=0.001)
    assert scenarios.load(name).intersection.offset == pytest.approx(offset)


@pytest.mark.parametrize("name", [*TYPES, "crossroads"])
def test_whoever_crosses_in_the_junction_is_a_foe(name, tmp_path):
    with running(net(name), "<routes/>", tmp_path):
        assert unseen(Network()) == []


@pytest.mark.parametrize("name", TYPES)
def test_cars_that_turn_let_riders_against_the_lane_pass(name, tmp_path):
    with running(net(name), "<routes/>", tmp_path):
        network = Network()
        origin = ways(network)
        against = [via for via, (lane, _) in origin.items() if lane in ("nci_0", "sci_0")]
        left = [
            via
            for via, (lane, to) in origin.items()
            if lane.startswith("si") and to.startswith("wo") and lane != "si_0"
        ]
        right = [
            via
            for via, (lane, to) in origin.items()
            if lane.startswith("ni") and to.startswith("wo") and lane != "ni_0"
        ]
        assert any(network.foes(a) & set(against) for a in left)
        assert any(network.foes(a) & set(against) for a in right)


def trips(**routes_of: str) -> str:
    vehicles = "".join(
        f'<vehicle id="{name}" type="{"car" if name.startswith("car") else "ebike_10"}" depart="0">'
        f'<route edges="{edges}"/></vehicle>'
        for name, edges in routes_of.items()
    )
    return f'<routes><vType id="car" vClass="passenger" speedDev="0"/>{Rider().types()}{vehicles}</routes>'


def lanes_driven(traffic: str, where: Path, tmp_path: Path, until: float = 260.0) -> dict[str, dict[str, float]]:
    """Vehicle -> lane -> seconds on it; all must have arrived."""
    seen: dict[str, dict[str, float]] = {}
    with running(where, traffic, tmp_path, lateral_resolution="0.35") as session:
        while session.time < until and not session.exhausted:
            session.step()
            for vehicle in libsumo.vehicle.getIDList():
                lane = libsumo.vehicle.getLaneID(vehicle)
                seen.setdefault(vehicle, {}).setdefault(lane, 0.0)
                seen[vehicle][lane] += session.dt
        assert session.exhausted
        assert libsumo.simulation.getCollidingVehiclesNumber() == 0
    return seen


@pytest.mark.parametrize("name", ["w0", "w2", "b2", "crossroads"])
def test_riders_turn_left_in_two_stages(name, tmp_path):
    seen = lanes_driven(trips(rider="si slo sli wo"), net(name), tmp_path)["rider"]
    waited = sum(seconds for lane, seconds in seen.items() if lane[:3] in ("slo", "sli"))
    if name == "crossroads":
        assert waited < 8  # nobody comes: he need not wait for a phase
    else:
        assert waited > 15  # until the crossing road has green


@needs_netconvert
@pytest.mark.parametrize("signal", [True, False])
def test_riders_turn_left_in_one_stage(signal, tmp_path):
    where = built(Intersection(lanes=2, bike_left="one_stage", signal=signal), tmp_path)
    assert {"si_0", "wo_0"} <= set(lanes_driven(trips(rider="si wo"), where, tmp_path)["rider"])


@pytest.mark.parametrize("name", TYPES)
def test_riders_turn_right_and_ride_against_the_lane(name, tmp_path):
    seen = lanes_driven(trips(against="sci nco", right="ni wo"), net(name), tmp_path)
    assert {"sci_0", "nco_0"} <= set(seen["against"])
    assert {"ni_0", "wo_0"} <= set(seen["right"])


def test_riders_against_the_lane_pass_those_who_come_towards_them(tmp_path):
    """On their own strip: boxes of 0.7 m do not touch on the way."""
    nearest = np.inf
    with running(net("w0"), trips(against="sci nco", with_it="ni so"), tmp_path, lateral_resolution="0.35") as session:
        while session.time < 150 and not session.exhausted:
            session.step()
            if {"against", "with_it"} <= set(libsumo.vehicle.getIDList()):
                a, b = (libsumo.vehicle.getPosition(v) for v in ("against", "with_it"))
                if abs(a[1] - b[1]) < 3:
                    nearest = min(nearest, abs(a[0] - b[0]))
    assert 0.7 < nearest < 2.0


@pytest.mark.parametrize("name", ["w0", "w2", "b2"])
def test_cars_keep_to_the_middle_of_lane_and_turning_path_in_the_sublane_model(name, tmp_path):
    scenario = scenarios.load(name)
    worst, turning = 0.0, 0
    with running(net(name), scenario.vehicles, tmp_path, lateral_resolution="0.35", seed="1") as session:
        while session.time < 120:
            session.step()
            for vehicle in libsumo.vehicle.getIDList():
                if vehicle.startswith("car"):
                    worst = max(worst, abs(libsumo.vehicle.getLateralLanePosition(vehicle)))
                    turning += libsumo.vehicle.getLaneID(vehicle).startswith(":")
    assert turning > 50
    assert worst < 0.05


def test_buildings_lie_at_the_corners(tmp_path):
    folder = sumo_nets.folder("w2t")
    with running(net("w2t"), "<routes/>", tmp_path, additional_files=str(folder / "w2t.add.xml")):
        types = {libsumo.polygon.getType(p) for p in libsumo.polygon.getIDList()}
        assert len(libsumo.polygon.getIDList()) == 3  # two corners and the side without arm
    assert types == {"building"}


@needs_netconvert
@pytest.mark.parametrize(
    "values",
    [
        {"arms": "new", "lanes": 2, "bike_lane": 1.6, "separation": 1.0, "signal": False},
        {"lanes": 2, "turn_radius": 22.0, "median": 2.0, "contraflow": True, "bike_left": "one_stage", "setback": 5.0},
        {"arms": "esw", "turn_radius": 12.5, "lane_width": 3.3, "bike_lane": 2.0, "setback": 1.0},
        {"lanes": 4, "turn_radius": 29.0, "lane_width": 3.25, "separation": 2.0, "contraflow": True},
        {"turn_radius": 10.0, "bike_left": "none", "signal": False},
    ],
)
def test_any_intersection_can_be_built_and_driven_without_a_collision(values, tmp_path):
    it = Intersection(**values)
    where = built(it, tmp_path)
    flow = 1200.0 if it.signal else 500.0
    collided = []
    traffic = routes(it, Demand(flow=flow))
    with running(where, traffic, tmp_path, lateral_resolution="0.35", seed="1") as session:
        assert unseen(Network()) == []
        while session.time < 120:
            session.step()
            collided += [c for c in libsumo.simulation.getCollisions() if "car" in c.collider + c.victim]
        assert libsumo.simulation.getDepartedNumber() + len(libsumo.vehicle.getIDList()) > 0
    assert collided == []


@pytest.mark.slow
def test_who_comes_when_and_how_fast_is_the_same_with_and_without_aeb():
    seen: dict[str, dict[str, tuple[str, float]]] = {}
    for strategy in ("none", "zhao2025"):
        comers = seen.setdefault(strategy, {})

        def note(_: object, comers: dict[str, tuple[str, float]] = comers) -> None:
            for vehicle in libsumo.simulation.getDepartedIDList():
                comers[vehicle] = libsumo.vehicle.getTypeID(vehicle), libsumo.vehicle.getSpeedFactor(vehicle)

        run(scenarios.load("w0"), strategy, duration=300, progress=note)
    assert len(seen["none"]) > 80
    assert seen["none"] == seen["zhao2025"]
