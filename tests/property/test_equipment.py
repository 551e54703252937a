"""Laws of who is equipped with what."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom

from aeb_sumo.drivers.streams import stream
from aeb_sumo.equipment import Equipment, Share, System

SYSTEMS = {name: System.of(*name.split("/")) for name in ("lin2021", "yan2025", "zhao2025", "zhao2025/radar")}
CARS = [f"car.{k}" for k in range(60)]

parts = st.lists(st.floats(0, 1), min_size=5, max_size=5).filter(lambda x: sum(x) > 0)
"""Shares of the four systems and of nobody, not yet to scale."""


def mix(shares):
    return Equipment(tuple(Share(system=SYSTEMS[name], share=share) for name, share in shares.items()))


def scaled(values):
    return dict(zip(SYSTEMS, (min(v / sum(values), 1.0) for v in values), strict=False))


def carried(equipment, cars=CARS, seed=1):
    systems = [equipment.of(car, vtype="t", vclass="passenger", seed=seed) for car in cars]
    return [s.name if s else "" for s in systems]


@given(parts, st.sampled_from(sorted(SYSTEMS)), st.floats(0, 1))
def test_a_larger_share_takes_nothing_away(values, name, part):
    """Who has the system keeps it, and who has any AEB keeps having one."""
    shares = scaled(values)
    room = 1 - sum(shares.values())
    before = carried(mix(shares))
    after = carried(mix(shares | {name: min(shares[name] + part * max(room, 0.0), 1.0)}))
    for one, two in zip(before, after, strict=True):
        assert one != name or two == name
        assert not one or two


@given(parts, st.permutations(sorted(SYSTEMS)))
def test_the_order_of_the_shares_does_not_matter(values, order):
    shares = scaled(values)
    assert mix({name: shares[name] for name in order}) == mix(shares)


@given(parts)
def test_the_text_reads_back_as_the_same(values):
    equipment = mix(scaled(values))
    assert Equipment.parse(equipment.text) == equipment


@given(st.floats(0, 1), st.integers(0, 2**31))
def test_one_system_is_in_the_cars_whose_number_is_below_its_share(share, seed):
    drawn = [stream(seed, "equip", car).random() < share for car in CARS]
    assert [bool(name) for name in carried(mix({"zhao2025": share}), seed=seed)] == drawn


@pytest.mark.parametrize("seed", range(3))
def test_shares_come_out_as_asked(seed):
    shares = {"lin2021": 0.05, "yan2025": 0.3, "zhao2025": 0.5, "zhao2025/radar": 0.1}
    n = 4000
    names = np.array(carried(mix(shares), [str(k) for k in range(n)], seed))
    for name, share in (*shares.items(), ("", 0.05)):
        low, high = binom.interval(0.9999, n, share)
        assert low <= (names == name).sum() <= high, name
