"""Figures of test cases, from drives made up here."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pandas as pd
import pytest

from aeb_sumo.drive import Drive
from aeb_sumo.errors import InputError
from aeb_sumo.reproduction import figures
from sumo_nets.left_turn.sources import OFFSET, crossing, start_of_turn

NAN = float("nan")


def vehicle(time, x, y, heading, speed, *, length=4.6, accel=0.0, phase=0, mu_known=NAN):
    return pd.DataFrame({
        "time_s": time, "x_m": x, "y_m": y, "heading_rad": heading, "length_m": length, "width_m": 1.8,
        "speed_mps": speed, "accel_mps2": accel, "phase": phase, "decel_mps2": -np.asarray(accel), "mu": 0.8,
        "mu_known": mu_known,
    }, index=range(len(time)))  # fmt: skip


def approach(*, decel=6.0, lead=0.0, crash=False):
    """10 m/s towards a lead 40 m ahead; warning after 1 s, braking after 2 s."""
    time = np.arange(0.0, 6.0, 0.1)
    speed = np.maximum(10.0 - decel * np.maximum(time - 2.0, 0.0), lead)
    x = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * 0.1)])
    accel = np.gradient(speed, time)
    phase = np.select([time < 1.0, time < 2.0, speed > lead], [0, 1, 3], 0)
    return Drive(
        time=time,
        ego=vehicle(time, x, 0.0, 0.0, speed, accel=accel, phase=phase, mu_known=0.8 + 0.01 * np.sin(time)),
        target=vehicle(time, 44.6 + lead * time, 0.0, 0.0, lead),
        crash_time=3.05 if crash else NAN,
        crash_speed=5.0 if crash else NAN,
        impact_speed=5.0 if crash else NAN,
    )


def turn(*, crash=False):
    """Straight on at 20 km/h up to where the turn begins, while an e-bike goes by."""
    time = np.arange(0.0, 4.0, 0.1)
    x0, y0 = start_of_turn(20)
    y = np.minimum(-5.0 + 5.56 * time, 8.0)
    return Drive(
        time=time,
        ego=vehicle(time, x0, y0 + y, np.pi / 2, np.where(y < 8.0, 5.56, 0.0)),
        target=vehicle(time, x0 - OFFSET, y0 + crossing(20)[1] + 6.0 - 5.56 * time, -np.pi / 2, 5.56, length=1.8),
        crash_time=2.0 if crash else NAN,
        crash_speed=5.0 if crash else NAN,
        impact_speed=5.0 if crash else NAN,
    )


def every():
    return {
        "one": figures.approach("One", approach()),
        "several": figures.approach("Two", {"a": approach(), "b": approach(decel=2.0, crash=True)}, ttc=True),
        "friction": figures.friction("Friction", approach()),
        "repeats": figures.repeats(
            "Peak", {"M": np.array([9.4, 9.6]), "N": [9.2]}, "m/s2", (0.0, 9.0), published={"M": (9.5, 9.5)}
        ),
        "paths": figures.turning_paths({"braked": turn(), "crashed": turn(crash=True)}),
    }


@pytest.mark.parametrize("kind", figures.KINDS)
def test_equal_figures_give_equal_files(kind, tmp_path):
    first = figures.save(every(), tmp_path / "deep" / "first", kind)
    again = every()
    second = figures.save(again, tmp_path / "second", kind)
    third = figures.save(again, tmp_path / "third", kind)
    assert [path.name for path in first] == [f"{name}.{kind}" for name in every()]
    for paths in zip(first, second, third, strict=True):
        files = {path.read_bytes() for path in paths}
        assert len(files) == 1
        assert len(files.pop()) > 1000


def test_figures_are_drawn_in_threads(tmp_path):
    def draw(k):
        return figures.save({"one": figures.approach("One", approach())}, tmp_path / str(k), "svg")

    with ThreadPoolExecutor(4) as pool:
        runs = list(pool.map(draw, range(4)))
    assert len({tuple(path.read_bytes() for path in paths) for paths in runs}) == 1


def test_every_panel_carries_its_unit():
    units = {
        "one": ["signal [-]", "gap [m]", "speed [km/h]", "deceleration [m/s²]"],
        "several": ["signal [-]", "TTC [s]", "gap [m]", "speed [km/h]", "deceleration [m/s²]"],
        "friction": ["friction coefficient [-]", "deceleration [m/s²]"],
        "repeats": ["Peak [m/s²]"],
        "paths": ["ahead of the start of the turn [m]", "ahead [m]", "ahead [m]"],
    }
    made = every()
    assert {name: [panel.get_ylabel() for panel in figure.axes] for name, figure in made.items()} == units
    assert made["one"].axes[-1].get_xlabel() == "time [s]"
    assert made["paths"].axes[0].get_xlabel() == "to the right of the start of the turn [m]"


def test_curves_show_signal_speed_and_deceleration():
    signal, _, speed, decel = figures.approach("One", approach()).axes
    time, phase = signal.lines[0].get_data()
    assert [float(time[np.argmax(phase == level)]) for level in (1, 2)] == pytest.approx([1.0, 2.0])
    assert speed.lines[-1].get_ydata()[0] == pytest.approx(36.0)
    assert decel.lines[0].get_ydata().max() == pytest.approx(6.0)


def test_the_time_axis_ends_a_second_after_the_last_drive():
    drives = {"hard": approach(), "soft": approach(decel=4.0)}
    assert figures.approach("Two", drives).axes[0].get_xlim() == pytest.approx((0.0, 5.5))


def test_curves_end_with_a_cross_at_the_crash():
    gap = figures.approach("Crash", approach(decel=2.0, crash=True)).axes[1]
    curve, cross = gap.lines
    assert curve.get_xdata()[-1] == pytest.approx(3.0)
    assert (cross.get_marker(), cross.get_xdata()[0]) == ("X", curve.get_xdata()[-1])


@pytest.mark.parametrize(("speeds", "drawn"), [((0.0, 0.0), 1), ((0.0, 2.0), 2)])
def test_leads_that_do_the_same_are_drawn_once(speeds, drawn):
    drives = {str(k): approach(lead=speed) for k, speed in enumerate(speeds)}
    legend = figures.approach("Leads", drives).legends[0]
    assert sum(text.get_text().startswith("lead") for text in legend.get_texts()) == drawn


@pytest.mark.parametrize("window", [(2.0, 4.0), (0.0, 1.0), None])
def test_values_and_some_of_the_window_are_in_view(window):
    panel = figures.repeats("TTC", {"M": [1.7, 1.8]}, "s", window).axes[0]
    low, high = panel.get_ylim()
    assert low < 1.7
    assert high > 1.8
    assert window is None or (low < window[1] and high > window[0])


def test_bodies_are_drawn_where_they_were_closest():
    figure = figures.turning_paths({"braked": turn()})
    ebike, car = figure.axes[0].patches
    assert (car.get_width(), ebike.get_width()) == (4.6, 1.8)
    corners = car.get_patch_transform().transform(car.get_path().vertices)
    assert corners[:, 1].max() == pytest.approx(8.0)
    assert figure.axes[1].get_title() == "braked: 3.00 m apart"


def test_bad_kind_is_named(tmp_path):
    with pytest.raises(InputError, match=r"^unknown kind of figure 'pdf'; there are: svg, png$"):
        figures.save({}, tmp_path, "pdf")


def test_bad_folder_is_named(tmp_path):
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(InputError, match=r"^cannot write figures to .*file: File exists$"):
        figures.save(every(), tmp_path / "file", "svg")


def test_file_that_cannot_be_written_is_named(tmp_path):
    (tmp_path / "one.svg").mkdir()
    with pytest.raises(InputError, match=r"^cannot write figures to .*one\.svg: Is a directory$"):
        figures.save(every(), tmp_path, "svg")
