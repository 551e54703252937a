import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aeb_sumo.perception.occlusion import NOBODY, Screens, diagonals, in_sight
from aeb_sumo.world.boxes import Boxes, separation

EYE, TARGET, OTHER = 0, 1, 2


def car(x=10.0, y=0.0, heading=0.0, length=4.6, width=1.8, slot=OTHER):
    """The screens of one body with its front bumper at (x, y)."""
    place = {"x": x, "y": y, "heading": heading, "length": length, "width": width}
    return Screens.of(diagonals(**{k: np.array([v]) for k, v in place.items()}), np.full(2, slot))


def wall(*pieces):
    return Screens.of(np.array(pieces, float).reshape(-1, 4), np.full(len(pieces), NOBODY))


def hidden(lines, ends, screens):
    return ~in_sight(lines[:, None], ends, screens, wall())


def blocked(screens, to=(20.0, 0.0), eye=(0.0, 0.0)):
    return bool(hidden(np.array([[*eye, *to]], float), np.array([[EYE, TARGET]]), screens)[0])


@pytest.mark.parametrize(
    ("screens", "expected"),
    [
        pytest.param(car(), True, id="a car between them"),
        pytest.param(car(y=0.85), True, id="its side reaches into the line"),
        pytest.param(car(y=0.95), False, id="it is beside the line"),
        pytest.param(car(x=30.0), False, id="it is behind the target"),
        pytest.param(car(x=-1.0), False, id="it is behind the eye"),
        pytest.param(car(slot=EYE), False, id="the own body"),
        pytest.param(car(slot=TARGET), False, id="the target's own body"),
        pytest.param(car(x=10.0, y=2.0, heading=np.pi / 2), True, id="a car across"),
        pytest.param(wall((5, -3, 5, 3)), True, id="a wall"),
        pytest.param(wall((5, 1, 5, 3)), False, id="a wall that ends before the line"),
        pytest.param(wall((-50, 1, 50, 1)), False, id="a long wall beside the line"),
        pytest.param(wall((-50, 1, 50, -1)), True, id="a long wall through the line"),
        pytest.param(wall((5, 0, 5, 3), (5, -3, 5, 0)), True, id="where two walls meet"),
        pytest.param(wall(), False, id="nothing"),
    ],
)
def test_what_hides(screens, expected):
    assert blocked(screens) == expected


def test_every_line_is_judged_alone_and_whatever_the_order_of_the_screens():
    rng = np.random.default_rng(1)
    pieces, owner = np.tile(rng.uniform(-50, 50, (60, 2)), 2) + rng.uniform(-3, 3, (60, 4)), rng.integers(-1, 8, 60)
    lines, ends = rng.uniform(-50, 50, (40, 4)), rng.integers(0, 8, (40, 2))
    together = hidden(lines, ends, Screens.of(pieces, owner))
    assert 0 < together.sum() < 40
    shuffled = rng.permutation(60)
    again = Screens.of(pieces[shuffled], owner[shuffled])
    assert [bool(hidden(lines[k : k + 1], ends[k : k + 1], again)[0]) for k in range(40)] == together.tolist()


def test_one_free_line_past_bodies_and_walls_is_enough():
    lines, ends = np.array([[[0, 0, 20, -1], [0, 0, 20, 1]]], float), np.array([[EYE, TARGET]])
    low, high = wall((10, -2, 10, 0)), wall((10, 0, 10, 2))
    assert in_sight(lines, ends, wall(), wall())[0]
    for screen in (low, high):
        assert in_sight(lines, ends, screen, wall())[0]
        assert in_sight(lines, ends, wall(), screen)[0]
    assert not in_sight(lines, ends, low, high)[0]


away = st.floats(-30, 30)


@given(away, away, st.floats(-np.pi, np.pi), away, away)
def test_a_body_hides_what_a_thin_beam_would_hit(x, y, heading, to_x, to_y):
    """Against the other definition: the line as a rectangle without width that overlaps the body's."""
    length, width = 4.6, 1.8
    body = Boxes.of(*(np.array([v]) for v in (x, y, heading, length, width)))
    ends = Boxes.of(*(np.array(v) for v in ([0.0, to_x], [0.0, to_y], [0.0, 0.0], [1e-9, 1e-9], [1e-9, 1e-9])))
    both = Boxes(*(np.repeat(getattr(body, f), 2) for f in Boxes.__dataclass_fields__))
    if (separation(both, ends) < 0.01).any():
        return  # who is inside a body is a matter for contact
    far = float(np.hypot(to_x, to_y))
    beam = Boxes.of(*(np.array([v]) for v in (to_x, to_y, np.arctan2(to_y, to_x), far, 0.0)))
    apart = float(separation(body, beam)[0])
    if abs(apart) > 1e-6:
        assert blocked(car(x, y, heading, length, width), to=(to_x, to_y)) == (apart < 0)
