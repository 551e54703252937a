"""Override that can be trusted."""

import libsumo
import numpy as np
import pytest

from aeb_sumo.simulate import run
from aeb_sumo.units import G
from aeb_sumo.world.friction import Friction
from aeb_sumo.world.observe import Traffic
from aeb_sumo.world.override import Override
from aeb_sumo.world.session import IMPOSED, Session
from tests.helpers import approach, vehicle


def stop(scenario, decel, mu=0.85, tyre=None):
    """Let the override brake one vehicle from its speed to a stop; returns (distance, what it was told)."""
    options = [*scenario.options, *IMPOSED, "--step-length", "0.1"]
    with Session(options) as session:
        traffic = Traffic(session.dt, every=True)
        override = Override(traffic, Friction(traffic, mu))
        started = None
        for _ in range(300):
            session.step()
            traffic.observe()
            override.verify()
            n = traffic.capacity
            if started is None and n:
                started = float(traffic.x[0]), float(traffic.speed[0])
            quiet, zeros = np.zeros(n, bool), np.zeros(n)
            override.drive(erring=quiet, erring_accel=zeros, aeb=np.full(n, decel), wrecked=quiet, wreck_speed=zeros)
            traffic.release_slots()
            if n and traffic.speed[0] == 0:
                break
        return float(traffic.x[0]) - started[0], started[1], override.audit


@pytest.mark.parametrize("decel", [1.0, 3.0, 6.0, 8.0])
@pytest.mark.parametrize("kmh", [20, 50, 100])
def test_stopping_distance_agrees_with_the_closed_form_within_1_percent(on_track, kmh, decel):
    one = vehicle("v", 600, kmh / 3.6)
    distance, speed, audit = stop(on_track(one), decel)
    assert distance == pytest.approx(speed**2 / (2 * decel), rel=0.01)
    assert audit.violations == 0
    assert audit.commands > 5


def test_friction_limits_everyone(on_track):
    one = vehicle("v", 600, 20)
    distance, speed, _ = stop(on_track(one), 9.0, mu=0.3)
    assert distance == pytest.approx(speed**2 / (2 * 0.3 * G), rel=0.01)


def test_a_driver_who_brakes_harder_is_not_released(on_track):
    """An attentive driver 30 m behind a standing car brakes hard himself; a feeble AEB must not keep him from it."""
    vehicles = vehicle("lead", 640, 0, inside='<stop lane="track_0" endPos="640" duration="100"/>') + vehicle(
        "v", 600, 15
    )
    with Session([*on_track(vehicles).options, *IMPOSED, "--step-length", "0.1"]) as session:
        traffic = Traffic(session.dt, every=True)
        override = Override(traffic, Friction(traffic, 0.85))
        short = []
        for _ in range(60):
            session.step()
            traffic.observe()
            override.verify()
            n = traffic.capacity
            if override.audit.commands and traffic.speed[traffic.slot["v"]] > 0:
                planned = libsumo.vehicle.getSpeedWithoutTraCI("v")
                short.append((traffic.speed[traffic.slot["v"]] - planned) / session.dt)
            quiet, zeros = np.zeros(n, bool), np.zeros(n)
            aeb = np.array([0.5 if v == "v" else 0.0 for v in traffic.ids] + [0.0] * (n - len(traffic.ids)))
            override.drive(erring=quiet, erring_accel=zeros, aeb=aeb, wrecked=quiet, wreck_speed=zeros)
        assert len(short) > 20
        assert np.mean(np.array(short) > 0.35) < 0.1, "he gets what he wants, but for the step in which he begins"
        ego, lead = traffic.slot["v"], traffic.slot["lead"]
        assert traffic.speed[ego] < 0.5
        assert traffic.x[lead] - traffic.length[lead] > traffic.x[ego], "no contact"
        assert override.audit.violations == 0


def test_the_vehicle_is_handed_back_as_it_was(on_track):
    one = vehicle("v", 600, 15)
    with Session([*on_track(one).options, *IMPOSED, "--step-length", "0.1"]) as session:
        traffic = Traffic(session.dt, every=True)
        override = Override(traffic, Friction(traffic, 0.85))
        for step in range(30):
            session.step()
            traffic.observe()
            override.verify()
            n = traffic.capacity
            if step == 0:
                libsumo.vehicle.setLaneChangeMode("v", 1109)
            aeb = np.where(5 <= step < 15, 3.0, 0.0) * np.ones(n)
            quiet, zeros = np.zeros(n, bool), np.zeros(n)
            override.drive(erring=quiet, erring_accel=zeros, aeb=aeb, wrecked=quiet, wreck_speed=zeros)
            modes = libsumo.vehicle.getSpeedMode("v"), libsumo.vehicle.getLaneChangeMode("v")
            if 5 <= step < 15:
                assert modes == (24, 0)
        assert modes == (31, 1109)
        assert traffic.accel[0] > 0, "SUMO's driver accelerates again"


def test_stopped_by_the_aeb_the_car_is_held_then_handed_over(on_track):
    result = run(on_track(approach(40, 0, 50)))
    row = result.interventions.iloc[0]
    assert row["ended_by"] == "standstill"
    assert row["speed_reduction_mps"] == pytest.approx(40 / 3.6)
    assert row["end_s"] - row["brake_s"] > 2.0, "brake and hold"


@pytest.mark.parametrize("mode", [(), ("--lateral-resolution", "0.6")], ids=["lane-based", "sublane"])
def test_no_violation_in_traffic(mode):
    from dataclasses import replace

    from aeb_sumo import scenarios

    highway = scenarios.load("highway")
    result = run(replace(highway, options=(*highway.options, *mode)), duration=120)
    assert result.runs["override_commands"].item() > 1000
    assert result.runs["override_violations"].item() == 0
