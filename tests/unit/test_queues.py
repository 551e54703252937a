import numpy as np
import pytest

from aeb_sumo.ledger.queues import behind


@pytest.mark.parametrize(
    ("lead", "through", "wrecked", "expected"),
    [
        pytest.param([1, 2, 3, -1], [1, 1, 1, 0], [0, 0, 0, 1], [1, 1, 1, 0], id="a queue behind a wreck"),
        pytest.param([1, 2, 3, -1], [1, 1, 0, 0], [0, 0, 0, 1], [0, 0, 0, 0], id="its head drives freely"),
        pytest.param([1, 2, 3, -1], [1, 1, 1, 1], [0, 0, 0, 0], [0, 0, 0, 0], id="a queue without a wreck"),
        pytest.param([1, 2, 3, -1], [1, 1, 1, 1], [0, 1, 0, 1], [1, 0, 1, 0], id="a wreck in the middle"),
        pytest.param([1, 0, 1, -1], [1, 1, 1, 0], [0, 0, 0, 1], [0, 0, 0, 0], id="two that wait for each other"),
        pytest.param([3, 3, 3, -1], [1, 0, 1, 0], [0, 0, 0, 1], [1, 0, 1, 0], id="several lanes behind one wreck"),
        pytest.param([], [], [], [], id="nobody"),
    ],
)
def test_who_waits_behind_a_wreck(lead, through, wrecked, expected):
    found = behind(np.array(lead, np.int64), through=np.array(through, bool), wrecked=np.array(wrecked, bool))
    assert found.tolist() == [bool(x) for x in expected]


def test_a_queue_of_a_thousand_is_followed_to_its_end():
    lead = np.append(np.arange(1, 1000), -1)
    wrecked = lead < 0
    assert behind(lead, through=~wrecked, wrecked=wrecked).sum() == 999
