"""Encounters from SUMO to table `conflicts`."""

import numpy as np
import pytest

from aeb_sumo.criticality import drac, required_decel, ttc, ttc2
from aeb_sumo.drivers.lapses import Lapse, Robots
from aeb_sumo.drivers.profile import Profile
from aeb_sumo.scenarios import Scenario
from aeb_sumo.simulate import run
from aeb_sumo.trace import Trace
from aeb_sumo.units import G
from sumo_nets import folder
from tests.helpers import approach, vehicle


def braking(decel, start=2.0, who="ego"):
    """The robot `who` brakes from `start` on for 4 s; the others hold their speeds."""
    return Profile(robots=Robots(programs=((who, (Lapse(start, start + 4.0, -decel),)),)))


def test_a_crash_is_an_encounter_that_ended_in_contact(on_track):
    result = run(on_track(approach(50, 20, 30)), "none")
    (row,) = result.conflicts.itertuples()
    assert (row.kind, row.ego, row.other) == ("following", "ego", "lead")
    assert (row.ego_vclass, row.ego_equipped, row.ego_error) == ("passenger", False, "robot")
    assert (row.crashed, row.near_crash, row.secondary) == (True, False, False)
    assert row.min_ttc_s == row.min_ttc2_s == row.min_gap_m == 0
    assert np.isnan(row.pet_s)
    # 30 km/h close 30 m in 3.6 s, of which the last 1.5 s count.
    assert row.exposed_s == pytest.approx(1.5, abs=0.11)
    assert row.end_s - row.begin_s == pytest.approx(3.6, abs=0.21)
    assert row.max_decel_mps2 == 0


@pytest.mark.parametrize(("decel", "near_crash"), [(0.45 * G, False), (0.55 * G, True)])
def test_a_near_crash_is_hard_braking_under_threat_without_contact(decel, near_crash, on_track):
    road = on_track(approach(50, 20, 30), drivers=braking(decel))
    result = run(road, "none")
    (row,) = result.conflicts.itertuples()
    assert len(result.crashes) == 0
    assert (row.near_crash, row.crashed) == (near_crash, False)
    assert row.max_decel_mps2 == pytest.approx(decel, abs=1e-6)


def test_hard_braking_without_a_threat_is_no_conflict(on_track):
    result = run(on_track(approach(50, 45, 60), drivers=braking(8.0)), "none")
    assert len(result.crashes) == len(result.conflicts) == 0


def test_the_measures_are_those_of_the_true_motion(on_track):
    """Computed again from positions and speeds of a lead that brakes, and an ego that brakes later and harder."""
    programs = (("lead", (Lapse(1.0, 4.0, -3.0),)), ("ego", (Lapse(2.5, 6.0, -6.5),)))
    trace = Trace()
    result = run(on_track(approach(60, 60, 20), drivers=Profile(robots=Robots(programs=programs))), "none", trace=trace)
    (row,) = result.conflicts.itertuples()
    frame = trace.frame().set_index(["vehicle", "time_s"])
    ego, lead = frame.loc["ego"], frame.loc["lead"]
    gap = lead["x_m"] - lead["length_m"] - ego["x_m"]
    closing, accel = ego["speed_mps"] - lead["speed_mps"], ego["accel_mps2"] - lead["accel_mps2"]
    during = (gap.index >= row.begin_s - 1e-9) & (gap.index <= row.end_s + 1e-9)
    time = ttc(gap=gap, closing_speed=closing)[during]
    need = required_decel(gap=gap, speed=ego["speed_mps"], lead_speed=lead["speed_mps"], lead_accel=lead["accel_mps2"])[
        during
    ]
    worst = gap.index[during][time.argmin()]
    assert row.min_ttc_s == pytest.approx(time.min(), rel=1e-6)
    assert row.min_ttc2_s == pytest.approx(ttc2(gap=gap, closing_speed=closing, closing_accel=accel)[during].min())
    assert row.max_drac_mps2 == pytest.approx(drac(gap=gap, closing_speed=closing)[during].max())
    assert row.max_required_decel_mps2 == pytest.approx(need.max())
    assert row.min_gap_m == pytest.approx(gap[during].min())
    assert row.exposed_s == pytest.approx(0.1 * (time < 1.5).sum())
    assert (row.x_m, row.y_m) == pytest.approx(tuple(ego.loc[worst, ["x_m", "y_m"]]))
    assert row.max_required_decel_mps2 > row.max_drac_mps2 > 0, "a braking lead asks for more, never for less"


def test_who_runs_into_a_wreck_is_in_a_secondary_conflict(on_track):
    conflicts = run(on_track(approach(50, 20, 30) + vehicle("third", 560, 14)), "none").conflicts
    crashed = conflicts[conflicts["crashed"]].set_index("ego")["secondary"]
    assert crashed.to_dict() == {"ego": False, "third": True}


def test_the_lane_beside_is_no_conflict(on_track):
    beside = vehicle("lead", 634.6, 5).replace('departLane="0"', 'departLane="1"')
    result = run(on_track(vehicle("ego", 600, 14) + beside), "none")
    assert len(result.crashes) == len(result.conflicts) == 0


def test_an_encounter_at_the_end_of_the_run_is_booked(on_track):
    result = run(on_track(approach(50, 20, 30), duration=3.0), "none")
    (row,) = result.conflicts.itertuples()
    assert not row.crashed
    assert row.end_s == pytest.approx(3.0)


def crossing(tmp_path, *, bike_starts, profile=None, **changes):
    """A car that turns left across the path of an oncoming e-bike, both robots unless told otherwise."""
    routes = tmp_path / "r.rou.xml"
    routes.write_text(
        '<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
        '<vType id="bike" vClass="bicycle" length="1.8" width="0.7" sigma="0" speedDev="0"/>'
        '<route id="left" edges="si wo"/><route id="on" edges="ni so"/>'
        '<vehicle id="car" type="car" route="left" depart="0" departLane="1" departPos="170" departSpeed="6"/>'
        f'<vehicle id="bike" type="bike" route="on" depart="0" departLane="0" departPos="{bike_starts}" '
        'departSpeed="5"/></routes>'
    )
    values = {"drivers": profile or Profile(robots=Robots()), "duration": 30.0} | changes
    return Scenario(name="w0", options=("-n", str(folder("w0") / "w0.net.xml"), "-r", str(routes)), **values)


def test_post_encroachment_time_at_a_crossing(tmp_path):
    """A metre farther on at 5 m/s is 0.2 s earlier, first behind the car, then with a crash, then before it."""
    found = {}
    for start in (172, 178, 184, 196, 202, 208):
        result = run(crossing(tmp_path, bike_starts=start), "none")
        (row,) = result.conflicts.itertuples()
        assert row.kind == "crossing"
        assert row.crashed == (len(result.crashes) == 1) == (start == 184)
        found[start] = row.ego, row.pet_s
    assert [found[s][0] for s in (172, 178, 196, 202, 208)] == ["bike"] * 2 + ["car"] * 3
    assert np.isnan(found[184][1])
    assert found[172][1] - found[178][1] == pytest.approx(1.2, abs=1e-6)
    assert np.diff([found[s][1] for s in (196, 202, 208)]) == pytest.approx([1.2, 1.2], abs=1e-6)


def test_post_encroachment_time_does_not_depend_on_the_step(tmp_path):
    coarse, fine = (
        run(crossing(tmp_path, bike_starts=202), "none", step_length=h).conflicts["pet_s"].item() for h in (0.1, 0.02)
    )
    assert coarse == pytest.approx(fine, abs=0.12), "robots depart at the end of the first step"


def test_counting_conflicts_changes_no_traffic(tmp_path, monkeypatch):
    from aeb_sumo.ledger.conflicts import Conflicts

    road = crossing(tmp_path, bike_starts=184)
    with_book = run(road, "none")
    monkeypatch.setattr(Conflicts, "step", lambda *_: None)
    without = run(road, "none")
    assert len(with_book.conflicts) > len(without.conflicts) == 0
    assert with_book.traffic.equals(without.traffic)
    assert with_book.crashes.equals(without.crashes)
