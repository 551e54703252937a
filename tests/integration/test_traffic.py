"""Table `traffic`, from SUMO to its rows."""

import xml.etree.ElementTree as ET
from dataclasses import replace

import numpy as np
import pytest

from aeb_sumo import scenarios
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.simulate import Progress, run
from aeb_sumo.trace import Trace
from tests.helpers import approach, vehicle


@pytest.fixture(scope="module")
def highway(tmp_path_factory):
    """The highway filling up; SUMO's tripinfo of it; vehicles at the end; last flow per lane behind the lane drop."""
    folder = tmp_path_factory.mktemp("highway")
    scenario = scenarios.load("highway").varied(demand=1.3, drivers=Profile())
    asked = ("--tripinfo-output", "trips.xml", "--tripinfo-output.write-unfinished", "true")
    asked += ("--tripinfo-output.write-undeparted", "true", "--additional-files", str(folder / "loops.add.xml"))
    loops = (f'<inductionLoop id="{k}" lane="narrow_{k}" pos="20" period="60" file="loops.xml"/>' for k in (0, 1))
    (folder / "loops.add.xml").write_text(f"<additional>{''.join(loops)}</additional>")
    seen: list[Progress] = []
    result = run(
        replace(scenario, options=(*scenario.options, *asked)),
        "none",
        duration=300,
        step_length=0.5,
        seed=1,
        sumo_output=folder,
        progress=seen.append,
    )
    (file,) = folder.glob("*trips.xml")
    trips = [{**trip.attrib} for trip in ET.parse(file).getroot().findall("tripinfo")]
    (file,) = folder.glob("*loops.xml")
    last = [float(loop.get("flow")) for loop in ET.parse(file).getroot() if float(loop.get("begin")) == 240]
    return result, trips, seen[-1].vehicles, np.mean(last)


def test_travel_times_are_those_of_sumos_tripinfo(highway):
    result, trips, *_ = highway
    durations = [float(trip["duration"]) for trip in trips if float(trip["arrival"]) >= 0 and not trip["vaporized"]]
    assert len(durations) == result.traffic["arrived"].sum() > 50
    assert result.traffic["travel_time_s"].sum() == pytest.approx(sum(durations), abs=1e-6)


def test_waiting_to_enter_is_sumos_delay_of_departure(highway):
    result, trips, *_ = highway
    # Flows depart inside steps; nobody waits for a place because of that.
    waited = sum(float(trip["departDelay"]) // 0.5 * 0.5 for trip in trips)
    assert waited > 100
    assert result.traffic["waiting_s"].sum() == pytest.approx(waited, rel=0.05)


def test_who_departed_and_neither_arrived_nor_was_removed_is_there(highway):
    result, _, there, _ = highway
    total = result.traffic[["departed", "arrived", "removed"]].sum()
    assert total["departed"] == result.runs["vehicles"].item() == result.exposure["vehicles"].sum()
    assert total["departed"] - total["arrived"] - total["removed"] == there
    by_class = result.traffic.groupby("vclass")["departed"].sum()
    assert by_class.to_dict() == result.exposure.groupby("vclass")["vehicles"].sum().to_dict()


def test_queues_before_the_lane_drop_discharge_as_fast_as_induction_loops_behind_it_count(highway):
    result, _, _, flow = highway
    early = result.traffic["end_s"] <= 60
    assert result.traffic.loc[early, "discharged"].sum() == 0, "nobody has come to the lane drop yet"
    late = result.traffic[result.traffic["begin_s"] == 240][["discharged", "headway_s"]].sum()
    assert late["discharged"] >= 8
    assert 1500 < flow == pytest.approx(late["discharged"] / late["headway_s"] * 3600, rel=0.1)


def test_parts_of_time_are_no_longer_than_the_whole(highway):
    traffic = highway[0].traffic
    assert (traffic["blocked_s"] <= traffic["delay_s"] + 1e-9).all()
    assert (traffic["standing_s"] <= traffic["delay_s"] / 0.9 + 1e-9).all(), "who stands loses nearly all of the time"
    assert (traffic["delay_s"] <= traffic["time_s"] + traffic["departed"]).all(), "but for samples of who just came"


# Two that stay on their lanes.
FOLLOWER = (
    '<vType id="follower" vClass="bus" length="12" maxSpeed="25" sigma="0" speedDev="0" lcSpeedGain="0" '
    'lcKeepRight="0" lcStrategic="-1"/><vType id="leader" vClass="coach" length="12" sigma="0" speedDev="0"/>'
)


def sampled(trace, names):
    """Speeds of vehicles once per second, (samples, vehicles)."""
    frame = trace.frame().pivot_table(index="time_s", columns="vehicle", values="speed_mps")[names]
    return frame.to_numpy()[9::10]


def test_delay_behind_a_wreck_is_that_of_those_who_queue_for_it(on_track):
    vehicles = (
        FOLLOWER
        + vehicle("a", 600, 0)
        + vehicle("b", 595.8, 10)
        + "".join(
            vehicle(f"late{k}", 400 - 50 * k, 14, kind="follower").replace('departLane="0"', f'departLane="{lane}"')
            for k, lane in enumerate((0, 0, 1))
        )
    )
    trace = Trace()
    result = run(on_track(vehicles, Profile(), duration=40.0), "none", blockage=100.0, trace=trace)
    assert len(result.crashes) == 1
    behind = result.traffic[result.traffic["vclass"] == "bus"]
    # Two come to stand behind the wreck, the third passes it; who is slower than half of what is allowed is queued.
    speed = sampled(trace, ["late0", "late1"]) / 25
    queue = np.where(speed < 0.5, 1 - speed, 0.0)
    assert behind["blocked_s"].sum() > 20
    assert behind["blocked_s"].sum() == pytest.approx(queue.sum(), rel=0.05)
    assert result.traffic.loc[result.traffic["vclass"] == "passenger", "blocked_s"].sum() == 0, "wrecks themselves"
    assert behind["stops"].sum() == 2
    assert result.traffic.loc[result.traffic["vclass"] == "passenger", ["stops", "standing_s"]].sum().sum() == 0


def test_without_a_wreck_nobody_waits_behind_one(on_track):
    """The same queue behind a vehicle that stops on schedule."""
    stop = '<stop lane="track_0" endPos="700" duration="100"/>'
    vehicles = FOLLOWER + vehicle("lead", 640, 10, "leader", stop) + vehicle("late", 400, 14, "follower")
    result = run(on_track(vehicles, Profile(), duration=40.0), "none")
    late = result.traffic[result.traffic["vclass"] == "bus"]
    assert late["standing_s"].sum() > 5
    assert result.traffic["blocked_s"].sum() == 0


def test_a_stop_counts_once_per_wave_and_creeping_on_counts_for_nothing(on_track):
    """The lead halts twice on schedule; in between it once creeps on, and once gets up to speed."""
    stops = "".join(f'<stop lane="track_0" endPos="{at}" duration="10"/>' for at in (700, 702, 800))
    vehicles = FOLLOWER + vehicle("lead", 640, 10, "leader", stops) + vehicle("late", 600, 10, "follower")
    trace = Trace()
    result = run(on_track(vehicles, Profile(), duration=90.0), "none", trace=trace)
    speed = sampled(trace, ["late"])[:, 0] * 3.6
    late = result.traffic[result.traffic["vclass"] == "bus"]
    assert late["stops"].sum() == 2
    assert late["standing_s"].sum() == pytest.approx((speed < 5).sum(), abs=1)
    lead = result.traffic[result.traffic["vclass"] == "coach"]
    assert lead["standing_s"].sum() <= 4, "at scheduled stops nobody stands, but for pulling up"


def test_nobody_on_the_road_makes_no_rows(on_track):
    assert len(run(on_track("", duration=90.0), "none").traffic) == 0


def test_wrecks_that_are_cleared_away_are_removed_and_have_not_arrived(on_track):
    traffic = run(on_track(approach(50, 20, 30), duration=60.0), "none", blockage=5.0).traffic
    assert traffic[["departed", "arrived", "removed"]].sum().tolist() == [2, 0, 2]
    assert traffic["travel_time_s"].sum() == 0
