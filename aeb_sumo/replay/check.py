"""Whether a run that was simulated again has become what the tables say."""

import numpy as np
import pandas as pd

import aeb_sumo
from aeb_sumo.errors import InputError
from aeb_sumo.replay.event import Event
from aeb_sumo.results import Results

__all__ = ["check"]

_SAME = 1e-6  # s, m, m/s: what is left of the last digits on another machine

# What is known of an event from its first instant; the rest may lie beyond the end of either run.
_KEYS = {"crash": ("striker", "struck"), "intervention": ("vehicle", "strategy")}
_FIGURES = {
    "crash": ("time_s", "x_m", "y_m", "striker_speed_mps", "struck_speed_mps", "impact_speed_mps"),
    "intervention": ("begin_s", "x_m", "y_m", "speed_mps", "warn_gap_m"),
}


def check(event: Event, again: Results) -> None:
    """Check that the event has happened again.

    Raises:
        InputError: it has not.
    """
    table = again.crashes if event.kind == "crash" else again.interventions
    if _there(event, table):
        return
    run = event.run
    now = again.runs.iloc[0]
    raise InputError(
        f"{event.kind}:{event.number} of {run['run_id']} does not happen again when its run is simulated: the "
        f"scenario, its files or the program have changed since (tables by aeb-sumo {run['aeb_sumo_version']} with "
        f"SUMO {run['sumo_version']}, now {aeb_sumo.__version__} with {now['sumo_version']})"
        + (f"; {now['reason']}" if now["outcome"] == "failed" else "")
    )


def _there(event: Event, table: pd.DataFrame) -> bool:
    same = np.ones(len(table), np.bool_)
    for column in _KEYS[event.kind]:
        same &= (table[column] == event.row[column]).to_numpy()
    for column in _FIGURES[event.kind]:
        wanted, found = float(event.row[column]), table[column].to_numpy(float)
        same &= (np.abs(found - wanted) <= _SAME) | (found == wanted) | (np.isnan(found) & np.isnan(wanted))
    return bool(same.any())
