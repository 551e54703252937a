"""A crossing of two roads with sidewalks; cars have the same id as the person on purpose: SUMO allows it.

The net is built from the plain XML beside it: `netconvert -n crossing.nod.xml -e crossing.edg.xml -x crossing.con.xml
-o crossing.net.xml --no-turnarounds`.
"""

from pathlib import Path

import libsumo
import pytest

from aeb_sumo.drivers.profile import ROBOTS
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import run
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.session import IMPOSED, Session
from aeb_sumo.world.walkers import Walkers
from aeb_sumo.world.wrecks import Wrecks

NET = Path(__file__).parents[1] / "data" / "crossing" / "crossing.net.xml"
TYPES = (
    '<vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
    '<vType id="ped" vClass="pedestrian" speedFactor="1" speedDev="0"/><route id="r" edges="wc ce"/>'
)
WALK = '<person id="0" type="ped" depart="0" departPos="{}"><walk edges="{}" arrivalPos="{}"/></person>'
ACROSS = WALK.format(60, "sc cn", 20)  # is in the way of the eastbound from 14.4 to 16.1 s
CAR = '<vehicle id="0" type="car" route="r" depart="{}" departPos="40" departSpeed="13"/>'


@pytest.fixture
def streets(tmp_path):
    """Makes a scenario at the crossing, with robots at the wheel, from SUMO's XML."""

    def make(traffic, more="", duration=30.0):
        (tmp_path / "x.rou.xml").write_text(f"<routes>{TYPES}{traffic}</routes>")
        (tmp_path / "x.add.xml").write_text(f"<additional>{more}</additional>")
        options = ("-n", str(NET), "-r", f"{tmp_path}/x.rou.xml", "-a", f"{tmp_path}/x.add.xml")
        return Scenario(name="crossing", options=options, duration=duration, drivers=ROBOTS)

    return make


def test_a_person_run_down_is_one_crash_and_gone_and_the_car_stands(streets):
    result = run(streets(ACROSS + CAR.format(6.6)), "none")
    (crash,) = result.crashes.itertuples()
    assert (crash.kind, crash.striker, crash.struck) == ("pedestrian", "0", "person:0")
    assert crash.struck_vclass == "pedestrian"
    assert crash.impact_speed_mps == pytest.approx(13.0, abs=0.1)
    assert crash.sumo_reported
    row = result.runs.iloc[0]
    assert (row["vehicles"], row["sumo_only"], row["contacts_dismissed"]) == (1, 0, 0)
    assert result.exposure["vehicles"].sum() == 1


@pytest.mark.parametrize("sensing", ["ideal", "fusion"])
@pytest.mark.parametrize("depart", [5.8, 6.6, 7.2])
def test_who_sees_crossing_traffic_brakes_for_a_person(streets, sensing, depart):
    result = run(streets(ACROSS + CAR.format(depart)), "zhao2025", sensing=sensing)
    acted = result.interventions.iloc[0]
    assert (acted["target"], acted["target_vclass"], acted["target_kind"]) == ("person:0", "pedestrian", "crossing")
    assert len(result.crashes) == 0


def test_who_sees_only_the_lead_does_not(streets):
    result = run(streets(ACROSS + CAR.format(6.6)), "staged")
    assert len(result.interventions) == 0
    assert len(result.crashes) == 1


@pytest.mark.parametrize("strategy", ["zhao2025", "yan2025"])
def test_a_person_on_the_sidewalk_is_no_matter(streets, strategy):
    result = run(streets(WALK.format(60, "wc", 140) + CAR.format(6.6)), strategy)
    assert len(result.interventions) == len(result.crashes) == 0


def test_a_person_in_a_vehicle_is_none_on_foot(streets):
    ride = '<person id="0" type="ped" depart="triggered"><ride from="wc" to="ce" lines="0"/></person>'
    result = run(streets(CAR.format(0) + ride.replace("triggered", "0")), "zhao2025")
    assert len(result.crashes) == 0
    assert result.runs["vehicles"].item() == 1


def test_a_building_at_the_corner_hides_the_person(streets):
    """Its corner stands half a metre off the car and 2 m off the way of the person."""
    house = '<poly id="h" type="building.house" shape="0,0 0,77 153.5,77 153.5,0"/>'
    first = [
        run(streets(ACROSS + CAR.format(6.6), more), "zhao2025").interventions["begin_s"].iloc[0]
        for more in ("", house.replace("building.house", "park"), house)
    ]
    assert first[0] == first[1]
    assert first[2] > first[0] + 0.3


@pytest.mark.parametrize(("ahead", "crashes"), [pytest.param(-0.5, 0, id="inside"), pytest.param(2.0, 1, id="before")])
def test_who_was_inside_a_standing_car_is_not_run_down_by_it(streets, ahead, crashes):
    """SUMO's persons walk through the bodies of vehicles that stand in their way, and are inside when these move on."""
    scenario = streets(CAR.format(0).replace('"13"', '"0"') + WALK.format(60, "wc", 140))
    with Session([*scenario.options, *IMPOSED, "--step-length", "0.1"]) as session:
        traffic, network = Traffic(0.1, every=True), Network()
        walkers, wrecks = Walkers(traffic, network), Wrecks(traffic, network, False, 60.0)
        found = []
        for step in range(30):
            session.step()
            traffic.observe()
            walkers.observe()
            traffic.follow(traffic.present)
            found += wrecks.step(session.time)
            libsumo.vehicle.setSpeed("0", 0.0 if step < 10 else 5.0)
            if step < 15 and libsumo.person.getIDCount():
                libsumo.person.moveToXY("0", "", 40.0 + ahead, float(traffic.y[traffic.slot["0"]]), keepRoute=2)
        assert traffic.x[traffic.slot["0"]] > 43
    assert len(found) == crashes


def test_more_persons_than_the_vehicles_ever_needed_room_for():
    """They enter when no vehicle does any more, and one of them is run down."""
    walk = '<person id="{}" type="ped" depart="{}" departPos="{}"><walk edges="{}" arrivalPos="{}"/></person>'
    crowd = "".join(walk.format(f"a{k:03}", 7.2, 1 + k * 0.4, "wc", 140) for k in range(100))
    routes = (
        '<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
        '<vType id="ped" vClass="pedestrian" speedFactor="1" speedDev="0"/><route id="r" edges="wc ce"/>'
        '<vehicle id="0" type="car" route="r" depart="6.6" departPos="40" departSpeed="13"/>'
        f"{crowd}{walk.format('zz', 7.2, 70, 'sc cn', 20)}</routes>"
    )
    scenario = Scenario(name="crowd", options=("-n", str(NET)), routes=routes, duration=25.0, drivers=ROBOTS)
    (crash,) = run(scenario, "none").crashes.itertuples()
    assert crash.kind == "pedestrian"
