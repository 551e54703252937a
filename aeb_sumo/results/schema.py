"""The tables: every column's name, type, unit and meaning. The one definition that writer, reader and README share.

Units: a suffix on the name says it too (`_s`, `_m`, `_mps`, ...). Unknown or not applicable is null for numbers (NaN in
pandas) and the empty string for names.
"""

from dataclasses import dataclass
from typing import Literal

import pyarrow as pa

__all__ = ["SCHEMA_VERSION", "TABLES", "Column", "Table"]

SCHEMA_VERSION = 3

DType = Literal["string", "int64", "float64", "bool"]


@dataclass(frozen=True)
class Column:
    """One column."""

    name: str
    dtype: DType
    unit: str
    meaning: str


@dataclass(frozen=True)
class Table:
    """One table."""

    name: str
    meaning: str
    columns: tuple[Column, ...]

    def arrow(self) -> pa.Schema:
        """Arrow schema, with unit and meaning as metadata of each field."""
        types = {"string": pa.string(), "int64": pa.int64(), "float64": pa.float64(), "bool": pa.bool_()}
        return pa.schema(
            [pa.field(c.name, types[c.dtype], metadata={"unit": c.unit, "meaning": c.meaning}) for c in self.columns],
            metadata={"table": self.name, "meaning": self.meaning, "schema_version": str(SCHEMA_VERSION)},
        )


def _table(name: str, meaning: str, *columns: tuple[str, DType, str, str]) -> Table:
    run = Column("run_id", "string", "-", "the run, as in `runs`")
    return Table(name, meaning, (run, *(Column(*c) for c in columns)))


_RUNS = _table(
    "runs",
    "One row per run: what was simulated, and the books of the run as a whole.",
    ("scenario", "string", "-", "name of the scenario, or path of the .sumocfg as given"),
    ("strategy", "string", "-", "AEB system; `none` for the baseline"),
    ("sensing", "string", "-", "sensor suite of the equipped vehicles; empty for the baseline"),
    ("parameters", "string", "-", "of the AEB system, where they differ from its defaults: `name=value`, by spaces"),
    ("penetration", "float64", "-", "share of cars equipped, 0 to 1"),
    ("seed", "int64", "-", "seed of SUMO and of all drivers"),
    ("errors", "string", "-", "errors the drivers make, joined by +; `attentive` for none"),
    ("step_length_s", "float64", "s", "step of the simulation"),
    ("begin_s", "float64", "s", "simulated time at the start"),
    ("end_s", "float64", "s", "simulated time reached"),
    ("demand", "float64", "-", "factor on all flows of the scenario"),
    ("ebike_share", "float64", "-", "of the road users; null where the scenario does not have it as a parameter"),
    ("weather", "string", "-", "`dry` or `wet`, as asked for; empty where nothing was said of it"),
    ("mu", "float64", "-", "friction coefficient of the road, where nothing else is said of it"),
    ("blockage_s", "float64", "s", "how long crashed vehicles stand before they leave"),
    ("outcome", "string", "-", "`completed`, `interrupted` (by the user) or `failed` (SUMO gave up)"),
    ("reason", "string", "-", "why it failed, in SUMO's words"),
    ("vehicles", "int64", "-", "vehicles that departed"),
    ("equipped", "int64", "-", "of these, vehicles with an AEB"),
    ("crashes", "int64", "-", "rows of this run in `crashes`"),
    ("sumo_collisions", "int64", "-", "pairs of vehicles that SUMO's own check reported as colliding"),
    ("confirmed_by_sumo", "int64", "-", "crashes among those pairs"),
    ("sumo_only", "int64", "-", "pairs that SUMO reported and the platform did not count"),
    ("contacts_dismissed", "int64", "-", "pairs that touched on lanes that have nothing to do with each other"),
    ("override_commands", "int64", "-", "speeds commanded"),
    ("override_violations", "int64", "-", "commands that SUMO did not execute within 0.001 m/s; should be 0"),
    ("override_worst_mps", "float64", "m/s", "largest difference between commanded and executed speed"),
    ("teleports", "int64", "-", "vehicles that SUMO took off the road to put them elsewhere"),
    ("aeb_sumo_version", "string", "-", "version of this program"),
    ("sumo_version", "string", "-", "version of SUMO"),
)

_CRASHES = _table(
    "crashes",
    "One row per crash: the first contact of a pair of vehicles.",
    ("crash_id", "int64", "-", "number within the run, from 0, in the order of time"),
    ("time_s", "float64", "s", "instant of the contact, interpolated inside the step"),
    ("kind", "string", "-", "`rear_end`, `left_turn_across_path`, `crossing`, `head_on` or `side`"),
    ("typology", "string", "-", "of a car and a two-wheeler: `221`, `321`, `322` or `601` (GDV catalogue); else empty"),
    ("x_m", "float64", "m", "impact point, in the network's coordinates"),
    ("y_m", "float64", "m", "impact point, in the network's coordinates"),
    ("lane", "string", "-", "lane of the struck vehicle's front"),
    ("striker", "string", "-", "id of the vehicle whose front hit the other"),
    ("struck", "string", "-", "id of the vehicle that was hit"),
    ("striker_vclass", "string", "-", "SUMO's vehicle class"),
    ("struck_vclass", "string", "-", "SUMO's vehicle class"),
    ("striker_vtype", "string", "-", "vehicle type of the scenario"),
    ("struck_vtype", "string", "-", "vehicle type of the scenario"),
    ("striker_equipped", "bool", "-", "it has an AEB"),
    ("struck_equipped", "bool", "-", "it has an AEB"),
    ("striker_speed_mps", "float64", "m/s", "its speed at contact"),
    ("struck_speed_mps", "float64", "m/s", "its speed at contact"),
    ("impact_speed_mps", "float64", "m/s", "magnitude of the relative velocity at contact"),
    ("striker_delta_v_mps", "float64", "m/s", "its change of velocity, by momentum (plastic, central impact)"),
    ("struck_delta_v_mps", "float64", "m/s", "its change of velocity, by momentum (plastic, central impact)"),
    ("angle_deg", "float64", "deg", "angle between the headings, 0 to 180"),
    ("striker_error", "string", "-", "error that its driver was making: `glance`, `hard_braking`, `failure_to_yield`"),
    ("struck_error", "string", "-", "error that its driver was making"),
    ("striker_aeb_phase", "int64", "-", "0 nothing, 1 warning, 2 partial, 3 full braking, at contact"),
    ("secondary", "bool", "-", "one of the two had crashed before"),
    ("sumo_reported", "bool", "-", "SUMO's own check reported the pair as well"),
)

_INTERVENTIONS = _table(
    "interventions",
    "One row per intervention: from the first warning or braking of an equipped vehicle until it has been doing "
    "neither for 1 s.",
    ("intervention_id", "int64", "-", "number within the run, from 0, in the order of their ends"),
    ("vehicle", "string", "-", "id of the equipped vehicle"),
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("phase", "string", "-", "highest phase reached: `warn`, `partial_brake` or `full_brake`"),
    ("target", "string", "-", "id of the vehicle it reacted to, at the trigger"),
    ("target_vclass", "string", "-", "SUMO's vehicle class"),
    ("target_kind", "string", "-", "`lead` on the own path, or `crossing` it"),
    ("begin_s", "float64", "s", "first warning or braking"),
    ("brake_s", "float64", "s", "first braking; null for a warning alone"),
    ("full_brake_s", "float64", "s", "first full braking; null if there was none"),
    ("end_s", "float64", "s", "last warning or braking"),
    ("ended_by", "string", "-", "`released`, `standstill`, `crash`, `left` (the network) or `run_end`"),
    ("warn_gap_m", "float64", "m", "gap at the beginning"),
    ("warn_ttc_s", "float64", "s", "time to collision at the beginning; inf when not closing"),
    ("warn_ttc2_s", "float64", "s", "second-order time to collision at the beginning"),
    ("trigger_gap_m", "float64", "m", "gap at the first braking; null for a warning alone"),
    ("trigger_ttc_s", "float64", "s", "time to collision at the first braking; null for a warning alone"),
    ("trigger_ttc2_s", "float64", "s", "second-order time to collision at the first braking"),
    ("speed_mps", "float64", "m/s", "own speed at the beginning"),
    ("closing_speed_mps", "float64", "m/s", "closing speed at the beginning"),
    ("max_decel_mps2", "float64", "m/s2", "largest deceleration by the AEB's brake"),
    ("speed_reduction_mps", "float64", "m/s", "own speed at the first braking less the lowest speed after it"),
    ("min_gap_m", "float64", "m", "smallest gap to a target meanwhile"),
    ("driver_error", "string", "-", "error that the driver was making at the beginning"),
    ("x_m", "float64", "m", "front bumper at the beginning, in the network's coordinates"),
    ("y_m", "float64", "m", "front bumper at the beginning, in the network's coordinates"),
)

_EXPOSURE = _table(
    "exposure",
    "Distance and time driven, by vehicle class and equipment; wrecks do not count.",
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("equipped", "bool", "-", "with an AEB"),
    ("vehicles", "int64", "-", "vehicles that departed"),
    ("distance_m", "float64", "m", "distance driven by all of them"),
    ("time_s", "float64", "s", "time on the road of all of them"),
)

_TRAFFIC = _table(
    "traffic",
    "Traffic per interval and vehicle class; wrecks count as standing.",
    ("begin_s", "float64", "s", "start of the interval"),
    ("end_s", "float64", "s", "end of the interval"),
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("departed", "int64", "-", "vehicles that entered"),
    ("arrived", "int64", "-", "vehicles that reached their destination"),
    ("pending", "int64", "-", "vehicles that waited for a place to enter, at the end of the interval"),
    ("flow_vph", "float64", "1/h", "arrivals per hour"),
    ("vehicles_mean", "float64", "-", "vehicles on the road, mean over the interval"),
    ("distance_m", "float64", "m", "distance driven"),
    ("time_s", "float64", "s", "time on the road"),
    ("speed_mps", "float64", "m/s", "space-mean speed: distance by time; null without vehicles"),
    (
        "delay_s",
        "float64",
        "s",
        "time lost against driving at the allowed speed, sampled once per second; scheduled stops do not count",
    ),
)

TABLES: dict[str, Table] = {t.name: t for t in (_RUNS, _CRASHES, _INTERVENTIONS, _EXPOSURE, _TRAFFIC)}
"""All tables by name."""
