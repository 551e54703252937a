"""Worlds that are legal and unusual: none may end in a traceback."""

import libsumo
import pytest

import sumo_nets
from aeb_sumo.errors import InputError
from aeb_sumo.scenarios import from_sumocfg
from aeb_sumo.simulate import run
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.session import IMPOSED, Session
from tests.helpers import vehicle

TRACK = sumo_nets.folder("track") / "track.net.xml"
ROUTES = (
    '<routes><vType id="car" vClass="passenger" length="4.6" width="1.82" sigma="0" speedDev="0"/>'
    '<route id="r" edges="track"/>{}</routes>'
)


@pytest.fixture
def world(tmp_path):
    """Makes a .sumocfg on the track."""

    def make(vehicles="", options=""):
        (tmp_path / "r.rou.xml").write_text(ROUTES.format(vehicles))
        path = tmp_path / "x.sumocfg"
        path.write_text(
            f'<configuration><net-file value="{TRACK}"/><route-files value="r.rou.xml"/>{options}</configuration>'
        )
        return path

    return make


def test_nobody_on_the_road(world):
    result = run(from_sumocfg(world()))
    assert result.runs["outcome"].item() == "completed"
    assert len(result.crashes) == len(result.exposure) == 0


def test_a_crash_in_the_step_of_insertion(world):
    result = run(from_sumocfg(world(vehicle("a", 100, 0) + vehicle("b", 95.8, 10))), "none", duration=5)
    (crash,) = result.crashes.itertuples()
    assert (crash.striker, crash.struck, crash.kind) == ("b", "a", "rear_end")


def test_a_route_that_breaks_in_the_middle_leaves_tables_marked_as_failed(world):
    late = vehicle("b", 100, 10).replace('depart="0"', 'depart="300"')  # SUMO reads routes 200 s ahead
    late += '<vehicle id="late" type="car" depart="450"><route edges="nowhere"/></vehicle>'
    result = run(from_sumocfg(world(vehicle("a", 100, 10) + late)), duration=600)
    row = result.runs.iloc[0]
    assert row["outcome"] == "failed"
    assert "nowhere" in row["reason"]
    assert 0 < row["end_s"] < 600


def test_an_option_that_ends_sumo_at_once_is_one_clear_error(world, tmp_path):
    path = world(options=f'<save-configuration value="{tmp_path}/saved.xml"/>')
    for _ in range(2):  # and does not block the process for the next run
        with pytest.raises(InputError, match="SUMO"):
            run(from_sumocfg(path))


@pytest.mark.parametrize("option", ['<remote-port value="8813"/>', '<e value="3"/>', "<end>3</end>"])
def test_options_of_other_uses(world, option):
    result = run(from_sumocfg(world(vehicle("a", 100, 10), option)), duration=3.0 if "port" in option else None)
    assert result.runs["end_s"].item() == pytest.approx(3.0)


def test_mesoscopic_is_refused(world):
    with pytest.raises(InputError, match="mesosim"):
        run(from_sumocfg(world(options='<mesosim value="true"/>')))


def test_wrecks_may_not_outstay_sumos_patience(world):
    path = world(options='<time-to-teleport value="30"/>')
    with pytest.raises(InputError, match="time-to-teleport of 30 s"):
        run(from_sumocfg(path), duration=5, blockage=40.0)
    assert run(from_sumocfg(path), duration=5).runs["blockage_s"].item() == 30


def test_a_linked_configuration_finds_the_files_beside_the_link(world, tmp_path):
    path = world(vehicle("a", 100, 10))
    real = tmp_path / "elsewhere" / "real.sumocfg"
    real.parent.mkdir()
    path.rename(real)
    path.symlink_to(real)
    assert run(from_sumocfg(path), duration=2).runs["vehicles"].item() == 1


def test_a_vehicle_that_parks_is_not_in_the_way(tmp_path):
    (tmp_path / "a.add.xml").write_text(
        '<additional><parkingArea id="p" lane="track_0" startPos="300" endPos="310" roadsideCapacity="1" width="0.5"/>'
        "</additional>"
    )
    (tmp_path / "r.rou.xml").write_text(
        ROUTES.format(
            '<vType id="wide" vClass="truck" length="8" width="3.4"/>'
            + vehicle("parks", 250, 10, inside='<stop parkingArea="p" duration="100"/>')
            + vehicle("passes", 100, 10, kind="wide")
        )
    )
    path = tmp_path / "x.sumocfg"
    path.write_text(
        f'<configuration><net-file value="{TRACK}"/><route-files value="r.rou.xml"/>'
        '<additional-files value="a.add.xml"/></configuration>'
    )
    result = run(from_sumocfg(path), duration=40)
    assert len(result.crashes) == 0
    assert result.exposure.set_index("vclass").loc["truck", "distance_m"] > 350, "it has passed"


def test_a_vehicle_taken_away_in_the_step_in_which_sumo_reads_a_flow_is_gone(world):
    """SUMO's balance of all that is to come stays the same: one vehicle less, one flow more."""
    kept = vehicle("v", 500, 5) + vehicle("w", 700, 0) + '<vehicle id="x" type="car" route="r" depart="10"/>'
    flows = "".join(f'<flow id="f{k}" type="car" route="r" begin="{k}" end="99" period="50"/>' for k in (30, 60))
    config = world(kept + flows, '<route-steps value="5"/>')
    with Session(["-c", str(config), "--step-length", "0.1", *IMPOSED]) as session:
        t, balance = Traffic(session.dt), []
        for step in range(110):
            if step == 100:
                libsumo.vehicle.remove("w")
                t.taken_away("w")
            session.step()
            t.observe()
            t.release_slots()
            balance.append(libsumo.simulation.getMinExpectedNumber())
    assert balance[100] == balance[99]
    assert sorted(t.slot) == ["v", "x"]
