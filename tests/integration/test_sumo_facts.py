"""What SUMO does and the platform relies on (shared/sumo-facts.md): a release that changes one fails here."""

import libsumo
import pytest

import sumo_nets
from aeb_sumo.world.session import IMPOSED, Session, SumoError, output_prefix
from tests.helpers import vehicle

TRACK = str(sumo_nets.folder("track") / "track.net.xml")
TYPES = (
    '<vType id="car" sigma="0" length="4.6" speedDev="0" lcStrategic="-1" lcSpeedGain="0" lcKeepRight="0"/>'
    '<route id="r" edges="track"/>'
)


@pytest.fixture
def track(tmp_path):
    """Starts a session on the track with vehicles given as XML."""
    sessions = []

    def start(vehicles, *options, imposed=IMPOSED, types=TYPES):
        routes = tmp_path / "r.rou.xml"
        routes.write_text(f"<routes>{types}{vehicles}</routes>")
        sessions.append(Session(["-n", TRACK, "-r", str(routes), "--step-length", "0.1", *imposed, *options]))
        sessions[0].step()
        return sessions[0]

    yield start
    for session in sessions:
        session.close()


ONE = vehicle("v", 500, 20)


def stop_with_ramp(decel):
    speed, start = libsumo.vehicle.getSpeed("v"), libsumo.vehicle.getPosition("v")[0]
    worst = 0.0
    while speed > 0:
        wanted = max(0.0, speed - decel * 0.1)
        libsumo.vehicle.setSpeed("v", wanted)
        libsumo.simulationStep()
        speed = libsumo.vehicle.getSpeed("v")
        worst = max(worst, abs(speed - wanted))
    return libsumo.vehicle.getPosition("v")[0] - start, worst


@pytest.mark.parametrize("mode", [24, 32])
def test_a_ramp_is_executed_exactly_and_stops_where_physics_says(track, mode):
    track(ONE)
    libsumo.vehicle.setSpeedMode("v", mode)
    distance, worst = stop_with_ramp(6.0)
    assert worst < 1e-9
    assert distance == pytest.approx(20**2 / 12, rel=1e-3)


def test_the_default_speed_mode_caps_the_deceleration_at_that_of_the_type(track):
    track(ONE)
    distance, _ = stop_with_ramp(6.0)
    assert distance > 43


def test_euler_integration_stops_half_a_step_short(track):
    track(ONE, imposed=("--no-step-log", "true"))
    libsumo.vehicle.setSpeedMode("v", 32)
    assert stop_with_ramp(6.0)[0] == pytest.approx(20**2 / 12 - 20 * 0.1 / 2, abs=0.02)


def test_the_planned_speed_shows_a_driver_who_brakes_harder_than_the_command(track):
    vehicles = vehicle("l", 560, 0) + ONE
    track(vehicles)
    libsumo.vehicle.setSpeedMode("l", 32)
    libsumo.vehicle.setSpeed("l", 0)
    libsumo.vehicle.setSpeedMode("v", 24)
    libsumo.vehicle.setLaneChangeMode("v", 0)
    harder = 0
    for _ in range(15):
        wanted = libsumo.vehicle.getSpeed("v") - 0.05
        libsumo.vehicle.setSpeed("v", wanted)
        libsumo.simulationStep()
        assert libsumo.vehicle.getSpeedWithoutTraCI("v") <= wanted + 1e-9
        harder += libsumo.vehicle.getSpeedWithoutTraCI("v") < wanted - 0.1
    assert harder > 5


@pytest.mark.parametrize("accel", [0.4, -0.7])
def test_an_acceleration_that_is_set_is_held_exactly(track, accel):
    """The platform leaves it to SUMO for up to 10 s; the audit of commands checks only what comes out."""
    track(ONE)
    libsumo.vehicle.setSpeedMode("v", 32)
    begin = libsumo.vehicle.getSpeed("v")
    libsumo.vehicle.setAcceleration("v", accel, 10.0)
    for step in range(1, 101):
        libsumo.simulationStep()
        assert libsumo.vehicle.getSpeed("v") == pytest.approx(begin + accel * 0.1 * step, abs=1e-9)


def test_the_acceleration_it_tells_is_the_difference_of_the_last_two_speeds(track):
    track(ONE + vehicle("ahead", 560, 5))
    before, different = libsumo.vehicle.getSpeed("v"), set()
    for _ in range(100):
        libsumo.simulationStep()
        now = libsumo.vehicle.getSpeed("v")
        assert libsumo.vehicle.getAcceleration("v") == (now - before) / 0.1
        different.add(now - before)
        before = now
    assert len(different) > 10


def test_who_is_removed_is_in_no_list_of_arrivals(track):
    """So the number of vehicles has to be watched."""
    track(ONE + vehicle("w", 700, 20))
    libsumo.vehicle.remove("w")
    for _ in range(3):
        libsumo.simulationStep()
        assert libsumo.simulation.getArrivedNumber() == 0
        assert libsumo.vehicle.getIDList() == ("v",)


def test_get_leader_leaves_out_min_gap(track):
    vehicles = vehicle("l", 604.6, 20) + ONE
    track(vehicles)
    gap = libsumo.vehicle.getPosition("l")[0] - 4.6 - libsumo.vehicle.getPosition("v")[0]
    leader, reported = libsumo.vehicle.getLeader("v", 200)
    assert leader == "l"
    assert reported + libsumo.vehicle.getMinGap("v") == pytest.approx(gap, abs=0.01)


def test_a_second_simulation_in_a_process_is_refused(track):
    track(ONE)
    with pytest.raises(RuntimeError, match="one simulation per process"):
        Session(["-n", TRACK])


def test_sumos_own_reason_is_shown(tmp_path):
    with pytest.raises(SumoError, match=r"nowhere\.net\.xml"):
        Session(["-n", str(tmp_path / "nowhere.net.xml")])


def test_outputs_go_where_they_are_sent(tmp_path):
    """The prefix leads out of the folder in which SUMO would have written, for options and additional files alike."""
    source, target = tmp_path / "deep" / "source", tmp_path / "target"
    source.mkdir(parents=True)
    target.mkdir()
    (source / "a.add.xml").write_text(
        '<additional><e1Detector id="d" lane="track_0" pos="9" period="10" file="d.xml"/></additional>'
    )
    (source / "r.rou.xml").write_text(f"<routes>{TYPES}{ONE}</routes>")
    (source / "run.sumocfg").write_text(
        f'<configuration><net-file value="{TRACK}"/><route-files value="r.rou.xml"/>'
        '<additional-files value="a.add.xml"/><tripinfo-output value="trips.xml"/>'
        '<log value="log.txt"/></configuration>'
    )
    before = sorted(source.iterdir())
    with Session(
        ["-c", str(source / "run.sumocfg"), "--output-prefix", output_prefix(str(target), "mine_")]
    ) as session:
        session.step()
    assert sorted(source.iterdir()) == before
    assert {p.name for p in target.iterdir()} == {"mine_d.xml", "mine_trips.xml", "mine_log.txt"}


def test_who_may_be_overlooked_is_a_parameter_of_the_vehicle():
    """`junctionModel.ignoreIDs` set at run time makes a left-turning car not yield to one e-bike."""

    def slowest(ignore):
        net = sumo_nets.folder("w0") / "w0.net.xml"
        with Session(["-n", str(net), "--step-length", "0.1", *IMPOSED]) as session:
            libsumo.vehicletype.copy("DEFAULT_BIKETYPE", "bike")
            libsumo.vehicletype.copy("DEFAULT_VEHTYPE", "car")
            libsumo.vehicletype.setImperfection("car", 0)
            libsumo.route.add("left", ["si", "wo"])
            libsumo.route.add("straight", ["ni", "so"])
            libsumo.vehicle.add("c", "left", typeID="car", departLane="1", departPos="150", departSpeed="8")
            libsumo.vehicle.add("b", "straight", typeID="bike", departLane="0", departPos="195", departSpeed="5")
            speeds = []
            for step in range(200):
                session.step()
                if step == 2 and ignore:
                    libsumo.vehicle.setParameter("c", "junctionModel.ignoreIDs", "b")
                if "c" in libsumo.vehicle.getIDList() and step > 2:
                    speeds.append(libsumo.vehicle.getSpeed("c"))
            return min(speeds)

    assert slowest(ignore=False) < 1.0
    assert slowest(ignore=True) > 4.0


def test_who_is_taken_away_is_missing_in_sumos_balance_alone(track):
    session = track(ONE + vehicle("w", 600, 20))
    balance = libsumo.simulation.getMinExpectedNumber
    for _ in range(5):
        before = balance()
        session.step()
        assert balance() == before + libsumo.simulation.getLoadedNumber() - libsumo.simulation.getArrivedNumber()
    libsumo.vehicle.remove("w")
    session.step()
    assert not libsumo.simulation.getArrivedNumber()
    assert balance() == before - 1
