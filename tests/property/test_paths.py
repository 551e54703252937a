import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo.world.paths import _at_the_same


@given(st.lists(st.integers(0, 4), max_size=12))
def test_pairs_at_the_same_junction_are_all_ordered_pairs_junction_by_junction(junctions):
    first, second = _at_the_same(np.array(junctions, np.int64))
    pairs = list(zip(first.tolist(), second.tolist(), strict=True))
    rows = range(len(junctions))
    expected = [(i, j) for i in rows for j in rows if i != j and junctions[i] == junctions[j]]
    assert pairs == sorted(expected, key=lambda pair: (junctions[pair[0]], pair))
