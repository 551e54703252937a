"""The net `left_turn`: the path of Yan et al. 2025, Table 3, in SUMO (shared/seeds.md 4; rows Y1, Y3 to Y5)."""

from xml.etree import ElementTree

import libsumo
import numpy as np
import pytest

import sumo_nets
from aeb_sumo.world.network import Network
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.paths import Paths
from aeb_sumo.world.session import IMPOSED, Session
from sumo_nets.left_turn.sources import APPROACH, OFFSET, crossing, start_of_turn
from sumo_nets.turning_path import YAN_TABLE_3

FOLDER = sumo_nets.folder("left_turn")
SPEEDS = (10, 20, 30)
DT = 0.02
UNTIL_MEETING = 8.0  # s from the start until both would be where their paths cross
EBIKE = 20 / 3.6
LENGTH = {"car": 4.6, "ebike": 1.8}

each_speed = pytest.mark.parametrize("v", SPEEDS)


@pytest.fixture(scope="module")
def shapes():
    """Lane -> (n, 2) points."""
    root = ElementTree.parse(FOLDER / "left_turn.net.xml").getroot()
    return {e.get("id"): np.array([p.split(",") for p in e.get("shape").split()], float) for e in root.iter("lane")}


def angle(line):
    """Direction of each piece of a line [deg], continuous."""
    return np.degrees(np.unwrap(np.arctan2(*np.diff(line, axis=0).T[::-1])))


@pytest.fixture(scope="module")
def drive():
    """All three encounters, nobody braking: (rows of time, x, y, heading [deg], speed) per vehicle, foes, zones, pairs.

    The e-bike's centre and the centre of the car's front bumper are to be where their paths cross 8 s after the start.
    """
    rows, foes, zones, collided = {}, {}, {}, set()
    options = ["-n", str(FOLDER / "left_turn.net.xml"), "-r", str(FOLDER / "left_turn.rou.xml")]
    with Session([*options, "--step-length", str(DT), *IMPOSED]) as session:
        traffic, network = Traffic(session.dt, every=True), Network()
        paths = Paths(traffic, network)
        for v in SPEEDS:
            speeds = {"car": v / 3.6, "ebike": EBIKE}
            begin = {"car": APPROACH + crossing(v)[0], "ebike": APPROACH + LENGTH["ebike"] / 2}
            for kind, route in (("car", f"turn_{v}"), ("ebike", f"straight_{v}")):
                name, speed = f"{kind}_{v}", speeds[kind]
                at = begin[kind] - speed * UNTIL_MEETING
                libsumo.vehicle.add(name, route, kind, departPos=str(at), departSpeed=str(speed))
                libsumo.vehicle.setSpeedMode(name, 32)
                libsumo.vehicle.setSpeed(name, speed)
            foes[v] = {k: network.foes(f":c_{v}_{k}_0") for k in (0, 1)}
        session.step()
        start = session.time
        while session.time < start + 25:
            traffic.observe()
            traffic.release_slots()
            paths.step()
            at = dict(zip(paths.turns.slot.tolist(), paths.turns.at.tolist(), strict=True))
            pairs = paths.crossings
            for slot in traffic.present.tolist():
                state = (session.time, traffic.x[slot], traffic.y[slot], traffic.heading[slot], traffic.speed[slot])
                rows.setdefault(traffic.ids[slot], []).append(state)
            for ego, other, zone in zip(pairs.ego.tolist(), pairs.other.tolist(), pairs.zone, strict=True):
                if traffic.ids[ego].startswith("car"):
                    zones.setdefault(traffic.ids[ego][4:], zone + np.array([at[ego]] * 2 + [at[other]] * 2))
            collided |= {frozenset((c.collider, c.victim)) for c in libsumo.simulation.getCollisions()}
            session.step()
    result = {}
    for name, states in rows.items():
        result[name] = np.array(states)
        result[name][:, 3] = np.degrees(np.unwrap(result[name][:, 3]))
    return result, foes, zones, collided


@each_speed
def test_lanes_lie_where_the_test_has_them(shapes, v):
    """Offset a = 4.8 m (printed, Table 1, W0); the turn is the path of Table 3, and the lanes join it."""
    x, y = start_of_turn(v)
    car, turn, leave = (shapes[lane] for lane in (f"car_{v}_0", f":c_{v}_1_0", f"exit_{v}_0"))
    bike = np.vstack([shapes[f"ebike_{v}_0"], shapes[f":c_{v}_0_0"], shapes[f"beyond_{v}_0"]])
    assert car == pytest.approx(np.array([[x, y - 150], [x, y]]), abs=0.001)
    assert car[:, 0] - bike[0, 0] == pytest.approx(OFFSET, abs=0.001)
    assert np.ptp(bike[:, 0]) == 0
    meet = y + crossing(v)[1]
    assert bike[[0, -1], 1] == pytest.approx([meet + 150, meet - 60], abs=0.002)
    path = YAN_TABLE_3[v].points(0.25)
    assert turn == pytest.approx(np.column_stack([x - path[:, 1], y + path[:, 0]]), abs=0.001)
    assert turn[0] == pytest.approx(car[-1], abs=0.001)
    assert turn[-1] == pytest.approx(leave[0], abs=0.001)
    assert angle(leave) == pytest.approx(180)


@pytest.mark.parametrize(
    ("v", "end", "turned"),
    [
        pytest.param(10, (13.76, 13.74), 89.92, id="Y3 10 km/h"),
        pytest.param(20, (22.32, 22.36), 90.12, id="Y3 20 km/h"),
        pytest.param(30, (40.88, 40.82), 89.92, id="Y3 30 km/h"),
    ],
)
def test_the_turn_ends_as_worked_out(shapes, v, end, turned):
    """Row Y3. Single pieces are turned by rounding to 1 mm, so a parabola is laid through the last clothoid."""
    turn = shapes[f":c_{v}_1_0"]
    dx, dy = turn[-1] - turn[0]
    assert (dy, -dx) == pytest.approx(end, abs=0.01)
    length = np.hypot(*np.diff(turn, axis=0).T)
    before_end = np.cumsum(length[::-1])[::-1] - length / 2
    path = YAN_TABLE_3[v]
    last = before_end < 2 * np.radians(path.clothoid_angle) / (1 / path.r_straight + 1 / path.r_turn)
    heading = np.polynomial.Polynomial.fit(before_end[last], angle(turn)[last], 2)(0)
    assert heading - 90 == pytest.approx(turned, abs=0.1)


def test_mean_radius(shapes):
    """Row Y4: the circle through P1, P3, P2 has 20.4 m, with P2 40 % along the rest of the turn (printed: 20 m).

    P1 is where the yaw rate exceeds 5 deg/s at 20 km/h, P3 the middle between P1 and P2 (printed).
    """
    turn = shapes[":c_20_1_0"]
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(turn, axis=0).T))])
    path = YAN_TABLE_3[20]
    curvature, straight, full = np.radians(5) / EBIKE, 1 / path.r_straight, 1 / path.r_turn
    clothoid = 2 * np.radians(path.clothoid_angle) / (straight + full)
    first = clothoid * (curvature - straight) / (full - straight)
    last = first + 0.4 * (along[-1] - first)
    a, b, c = (np.array([np.interp(s, along, turn[:, k]) for k in (0, 1)]) for s in (first, (first + last) / 2, last))
    twice_area = abs((b - a)[0] * (c - a)[1] - (b - a)[1] * (c - a)[0])
    radius = np.linalg.norm(b - c) * np.linalg.norm(a - c) * np.linalg.norm(a - b) / (2 * twice_area)
    assert radius == pytest.approx(20.4, abs=0.05)


@each_speed
def test_the_car_follows_the_path(drive, v):
    rows = drive[0][f"car_{v}"]
    x, y = start_of_turn(v)
    path = YAN_TABLE_3[v].points(0.005)
    path = np.column_stack([x - path[:, 1], y + path[:, 0]])
    front = rows[(rows[:, 2] > y) & (rows[:, 1] > path[-1, 0]), 1:3]
    assert max(np.hypot(*(path - p).T).min() for p in front) < 0.02
    assert rows[:, 4] == pytest.approx(v / 3.6)
    assert np.hypot(*np.diff(rows[:, 1:3], axis=0).T) == pytest.approx(v / 3.6 * DT, rel=2e-3)


@pytest.mark.parametrize(("v", "yaw_rate"), [(10, 15.9), (20, 19.9), (30, 16.5)])
def test_the_car_turns_smoothly(drive, v, yaw_rate):
    """No jumps of the heading, which SUMO takes from both bumpers; yaw rates of shared/seeds.md 4.2 [deg/s]."""
    heading = drive[0][f"car_{v}"][:, 3]
    assert np.abs(np.diff(heading)).max() < 1
    per_10_cm = np.diff(np.interp(np.arange(0, len(heading), 0.1 / (v / 3.6 * DT)), np.arange(len(heading)), heading))
    assert np.abs(per_10_cm).max() < 1
    half_second = round(0.5 / DT)
    rate = (heading[half_second:] - heading[:-half_second]) / 0.5
    assert rate.max() == pytest.approx(yaw_rate, abs=0.1)


@each_speed
def test_the_paths_conflict(drive, v):
    """Foes for SUMO, which reports the collision; the platform finds where the paths cross."""
    _, foes, zones, collided = drive
    assert foes[v] == {0: {f":c_{v}_1_0"}, 1: {f":c_{v}_0_0"}}
    assert frozenset((f"car_{v}", f"ebike_{v}")) in collided
    own_from, own_to, other_from, other_to = zones[str(v)]
    assert own_from < APPROACH + crossing(v)[0] < own_to
    assert other_from < APPROACH < other_to


@each_speed
def test_the_car_has_to_yield(v):
    """Left to SUMO, the car stops for the e-bike."""
    options = ["-n", str(FOLDER / "left_turn.net.xml"), "-r", str(FOLDER / "left_turn.rou.xml")]
    with Session([*options, "--step-length", "0.1", *IMPOSED]) as session:
        libsumo.vehicle.add("car", f"turn_{v}", "car", departPos="110", departSpeed="8")
        libsumo.vehicle.add("ebike", f"straight_{v}", "ebike", departPos="90", departSpeed="8")
        session.step()
        slowest = 8.0
        while "car" in libsumo.vehicle.getIDList():
            slowest = min(slowest, libsumo.vehicle.getSpeed("car"))
            assert not libsumo.simulation.getCollisions()
            session.step()
    assert slowest < 4


def bearings(v, offset, front=3.6):
    """Bearing [deg] from the front bumper to the e-bike's centre from -3.0 to -0.3 s before the impact.

    The rear axle follows the path, the bumper is 3.6 m ahead of it (shared/seeds.md 4.4); the impact is when the middle
    of the bumper is at the e-bike's centre.
    """
    path = YAN_TABLE_3[v].points(0.01)
    steps = np.diff(path, axis=0)
    along = np.concatenate([[0.0], np.cumsum(np.hypot(*steps.T))])
    heading = np.radians(np.interp(along, (along[1:] + along[:-1]) / 2, angle(path)))
    bumper = path + front * np.column_stack([np.cos(heading), np.sin(heading)])
    at_impact = np.interp(offset, bumper[:, 1], along)
    t = np.linspace(-3.0, -0.3, 271)
    s = at_impact + v / 3.6 * t
    own = np.interp(s, along, heading)
    x = np.where(s < 0, s, np.interp(s, along, path[:, 0])) + front * np.cos(own)
    y = np.interp(s, along, path[:, 1]) + front * np.sin(own)
    bike = np.interp(at_impact, along, bumper[:, 0]) - EBIKE * t
    return np.degrees(np.arctan2(offset - y, bike - x) - own)


def test_a_field_of_view_of_52_degrees_suffices():
    """Row Y5: at most 15.9 deg to either side."""
    worst = max(np.abs(bearings(v, a)).max() for v in SPEEDS for a in (3.5, 4.0, 4.4, 4.8))
    assert worst == pytest.approx(15.9, abs=0.3)


@pytest.mark.parametrize(("v", "worst"), [(10, 21.7), (20, 9.2), (30, 7.2)])
def test_the_e_bike_is_in_view_in_sumo(drive, v, worst):
    """Row Y5 in SUMO. There the front bumper follows the path, not its rear axle, so bearings are larger at 10 km/h."""
    car, bike = drive[0][f"car_{v}"], drive[0][f"ebike_{v}"]
    n = min(len(car), len(bike))
    car, bike = car[:n], bike[:n]
    centre = bike[:, 1:3] + [0, LENGTH["ebike"] / 2]
    impact = np.argmin(np.hypot(*(car[:, 1:3] - centre).T))
    assert np.hypot(*(car[impact, 1:3] - centre[impact])) < 0.2
    when = slice(impact - round(3 / DT), impact - round(0.3 / DT) + 1)
    dx, dy = (centre - car[:, 1:3])[when].T
    bearing = (np.degrees(np.arctan2(dy, dx)) - car[when, 3] + 180) % 360 - 180
    assert np.abs(bearing).max() < 52 / 2
    assert np.abs(bearing).max() == pytest.approx(worst, abs=0.5)


def test_counts_and_percentages_of_table_1_agree():
    """Row Y1: they are those of 273 to 280 crashes (printed: 94, 34 % for W0 to 16, 6 % for B2)."""
    counts, percent = np.array([94, 64, 25, 16, 16]), [34, 23, 9, 6, 6]
    fitting = [n for n in range(215, 400) if np.rint(100 * counts / n).tolist() == percent]
    assert fitting == list(range(273, 281))
    assert counts.sum() == 215
    assert {round(100 * 215 / n) for n in fitting} & {78}
