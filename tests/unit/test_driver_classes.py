import numpy as np
import pytest

from aeb_sumo.drivers.classes import distances, driver_classes, reaction_time
from aeb_sumo.errors import InputError

HEADER = "age_years,sex,experience_years,slope_s_per_kmh,intercept_s\n"
ROWS = "".join(f"18-30,male,up to 2,0.005,{b}\n" for b in (1.2, 1.0, 0.9, 0.8))


def written(folder, text):
    path = folder / "classes.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_the_packaged_lines_give_four_classes_from_slow_to_fast():
    """Seeds 5.3."""
    classes = driver_classes()
    assert [c.intercept for c in classes] == pytest.approx([1.2, 1.05, 0.9, 0.8])
    assert [c.slope for c in classes] == pytest.approx([0.005] * 4)
    assert [len(c.groups) for c in classes] == [2, 2, 3, 2]
    assert classes[0].groups == ("50-70, male, up to 2", "50-70, female, 2-5")
    assert driver_classes() is classes


def test_distance_matrix():
    d = distances(np.array([[0.003, 1.0], [0.0, 1.004], [0.003, 1.0]]))
    assert d == pytest.approx(np.array([[0, 0.005, 0], [0.005, 0, 0.005], [0, 0.005, 0]]))


def test_reaction_time():
    classes = driver_classes()
    assert reaction_time(classes, 1, 20.0) == pytest.approx(1.3)
    assert reaction_time(classes, [1, 2, 3, 4], 20.0) == pytest.approx([1.3, 1.15, 1.0, 0.9])
    assert reaction_time(classes, 1, [-10.0, 0.0, 60.0, 90.0]) == pytest.approx([1.2, 1.2, 1.5, 1.5])


def test_an_own_file(tmp_path):
    classes = driver_classes(written(tmp_path, "# mine\n\n" + HEADER + ROWS))
    assert [c.intercept for c in classes] == pytest.approx([1.2, 1.0, 0.9, 0.8])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        pytest.param("", r"classes\.csv: column age_years is missing; there are: none", id="empty"),
        pytest.param(
            HEADER.replace("intercept_s", "b") + ROWS,
            "column intercept_s is missing; there are: age_years",
            id="column",
        ),
        pytest.param(
            HEADER + ROWS + "18-30,male,2-5,fast,1\n",
            r"classes\.csv, row 6: slope_s_per_kmh is 'fast'; allowed: a finite number",
            id="text",
        ),
        pytest.param(
            HEADER + ROWS + "18-30,male,2-5,0\n", "row 6: intercept_s is ''; allowed: a finite", id="short row"
        ),
        pytest.param("#\n" + HEADER + ROWS + "a,b,c,nan,1\n", "row 7: slope_s_per_kmh is 'nan'", id="nan"),
        pytest.param(HEADER + ROWS + "a,b,c,0.1,-0.1\n", r"row 6: intercept_s is -0\.1; allowed: 0 or more", id="at 0"),
        pytest.param(
            HEADER + ROWS + "a,b,c,-0.03,1.2\n",
            r"row 6: slope_s_per_kmh is -0\.03; allowed: -0\.02 or more",
            id="at 60",
        ),
        pytest.param(HEADER + ROWS[: len(ROWS) // 4 * 3], "3 rows; allowed: 4 or more", id="too few"),
    ],
)
def test_a_bad_file_is_refused(tmp_path, text, message):
    with pytest.raises(InputError, match=message) as caught:
        driver_classes(written(tmp_path, text))
    assert "\n" not in str(caught.value)


def test_a_file_that_cannot_be_read(tmp_path):
    with pytest.raises(InputError, match="No such file"):
        driver_classes(tmp_path / "none.csv")
    with pytest.raises(InputError, match="Is a directory"):
        driver_classes(tmp_path)
    (tmp_path / "binary").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(InputError, match="UTF-8"):
        driver_classes(tmp_path / "binary")
