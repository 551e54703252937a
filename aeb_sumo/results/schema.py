"""The tables: every column's name, type, unit and meaning. The one definition that writer, reader and README share.

Units: a suffix on the name says it too (`_s`, `_m`, `_mps`, ...). Unknown or not applicable is null for numbers (NaN in
pandas) and the empty string for names.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import pyarrow as pa

__all__ = ["SCHEMA_VERSION", "TABLES", "VERDICTS", "Column", "Table"]

SCHEMA_VERSION = 4

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
        return self._arrow

    @cached_property
    def _arrow(self) -> pa.Schema:
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
    ("strategy", "string", "-", "AEB system; `none` for the baseline; of a mix `[kind:]system=share`, by commas"),
    ("sensing", "string", "-", "sensor suites of the equipped vehicles, joined by +; empty for the baseline"),
    (
        "parameters",
        "string",
        "-",
        "of the systems, where not their defaults: `name=value`, by spaces; of a mix `system.name=value`",
    ),
    ("penetration", "float64", "-", "share of cars equipped, 0 to 1; null where it depends on their kind"),
    ("seed", "int64", "-", "seed of SUMO and of all drivers"),
    ("drivers", "string", "-", "driver profile, by name or file"),
    ("step_length_s", "float64", "s", "step of the simulation"),
    ("begin_s", "float64", "s", "simulated time at the start"),
    (
        "end_s",
        "float64",
        "s",
        "simulated time reached; null for a run that died or hung, of which nothing else is known",
    ),
    ("demand", "float64", "-", "factor on all flows of the scenario"),
    ("ebike_share", "float64", "-", "of the road users; null where the scenario does not have it as a parameter"),
    ("weather", "string", "-", "`dry` or `wet`, as asked for; empty where nothing was said of it"),
    ("mu", "float64", "-", "friction coefficient of the road, where nothing else is said of it"),
    ("blockage_s", "float64", "s", "how long crashed vehicles stand before they leave"),
    (
        "outcome",
        "string",
        "-",
        "`completed`, `interrupted` (by the user) or `failed` (SUMO gave up, or the run died or hung)",
    ),
    ("reason", "string", "-", "why it failed"),
    ("vehicles", "int64", "-", "vehicles that departed"),
    ("equipped", "int64", "-", "of these, vehicles with an AEB"),
    ("crashes", "int64", "-", "rows of this run in `crashes`"),
    ("sumo_collisions", "int64", "-", "pairs of vehicles that SUMO's own check reported as colliding"),
    ("confirmed_by_sumo", "int64", "-", "crashes among those pairs"),
    ("sumo_only", "int64", "-", "pairs that SUMO reported and the platform did not count"),
    ("contacts_dismissed", "int64", "-", "pairs that touched on lanes that have nothing to do with each other"),
    ("override_commands", "int64", "-", "speeds commanded"),
    (
        "override_violations",
        "int64",
        "-",
        "commands not executed within 0.001 m/s, but at scheduled stops; should be 0",
    ),
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
    ("kind", "string", "-", "`rear_end`, `left_turn_across_path`, `crossing`, `head_on`, `side` or `pedestrian`"),
    ("typology", "string", "-", "of a car and a two-wheeler: `221`, `321`, `322` or `601` (GDV catalogue); else empty"),
    ("x_m", "float64", "m", "impact point, in the network's coordinates"),
    ("y_m", "float64", "m", "impact point, in the network's coordinates"),
    ("lane", "string", "-", "lane of the struck vehicle's front"),
    ("striker", "string", "-", "id of the vehicle whose front hit the other; of a person: `person:` and the id"),
    ("struck", "string", "-", "id of the vehicle that was hit; of a person: `person:` and the id"),
    ("striker_vclass", "string", "-", "SUMO's vehicle class"),
    ("struck_vclass", "string", "-", "SUMO's vehicle class"),
    ("striker_vtype", "string", "-", "vehicle type of the scenario"),
    ("struck_vtype", "string", "-", "vehicle type of the scenario"),
    ("striker_equipped", "bool", "-", "it has an AEB"),
    ("struck_equipped", "bool", "-", "it has an AEB"),
    ("striker_strategy", "string", "-", "its AEB system, with `/suite` where not the system's own; empty without"),
    ("struck_strategy", "string", "-", "its AEB system; empty without"),
    ("striker_speed_mps", "float64", "m/s", "its speed at contact"),
    ("struck_speed_mps", "float64", "m/s", "its speed at contact"),
    ("impact_speed_mps", "float64", "m/s", "magnitude of the relative velocity at contact"),
    ("striker_delta_v_mps", "float64", "m/s", "its change of velocity, by momentum (plastic, central impact)"),
    ("struck_delta_v_mps", "float64", "m/s", "its change of velocity, by momentum (plastic, central impact)"),
    (
        "striker_death_risk",
        "float64",
        "-",
        "risk that the person on the striker dies; null where no curve applies: only for e-bike riders, by the speed "
        "of the passenger car whose front hit them, so for a striker in a head-on crash alone",
    ),
    ("struck_death_risk", "float64", "-", "the same for the person on the struck vehicle"),
    (
        "striker_serious_risk",
        "float64",
        "-",
        "risk that the person on the striker is injured seriously (MAIS3+) or dies; null where no curve applies: only "
        "for riders and car drivers whom the front of a passenger car hit, so for a striker in a head-on crash alone",
    ),
    ("struck_serious_risk", "float64", "-", "the same for the person on the struck vehicle"),
    ("angle_deg", "float64", "deg", "angle between the headings, 0 to 180"),
    (
        "striker_error",
        "string",
        "-",
        "error that its driver was making: `glance`, `hard_braking`, `surprised` (a vehicle ahead brakes hard), "
        "`failure_to_yield`, `not_seen` (hidden, or too shortly in sight), `red_light`, `robot`; empty for none",
    ),
    ("struck_error", "string", "-", "the same of its driver"),
    ("striker_aeb_phase", "int64", "-", "0 nothing, 1 warning, 2 partial, 3 full braking, at contact"),
    ("secondary", "bool", "-", "one of the two had crashed before"),
    ("sumo_reported", "bool", "-", "SUMO's own check reported the pair as well"),
)

VERDICTS = {
    "avoided": "a crash otherwise, none with it",
    "mitigated": "a crash either way, with less risk of serious injury, or, where no curve applies, less impact speed",
    "unchanged": "a crash either way, as hard as otherwise",
    "worsened": "a crash either way, harder than otherwise",
    "induced": "a crash with it, none otherwise",
    "precautionary": "no crash either way, but a near-crash otherwise, or a crossing within a second",
    "unneeded": "no crash either way, and no near-crash otherwise",
    "unknown": "the world could not be forked, or the fork did not answer",
}
"""Verdict -> what it means."""

_WORLD: tuple[tuple[str, DType, str, str], ...] = (
    ("crash", "bool", "-", "the vehicle, or one of the three behind it, crashes in the window; null without verdict"),
    ("impact_speed_mps", "float64", "m/s", "impact speed of the hardest of these crashes; null without crash"),
    ("delta_v_mps", "float64", "m/s", "the larger change of velocity of the two in it"),
    ("serious_risk", "float64", "-", "risk that somebody is injured seriously in it; null where no curve applies"),
    (
        "near_crash",
        "bool",
        "-",
        "no crash, but a driver (not an AEB) braked as in a near-crash (see `conflicts`)",
    ),
    ("min_gap_m", "float64", "m", "smallest gap to one it closed in on or whose path it crossed; null for nobody"),
    ("pet_s", "float64", "s", "smallest post-encroachment time below 3 s of its crossings; null for none"),
    ("follower_decel_mps2", "float64", "m/s2", "largest deceleration of one who follows within 3 s"),
)

_INTERVENTIONS = _table(
    "interventions",
    "One row per intervention: from the first warning or braking of an equipped vehicle until it has been doing "
    "neither for 1 s.",
    ("intervention_id", "int64", "-", "number within the run, from 0, in the order of their ends"),
    ("vehicle", "string", "-", "id of the equipped vehicle"),
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("strategy", "string", "-", "its AEB system, with `/suite` where not the system's own"),
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
    ("driver_error", "string", "-", "error that the driver was making at the beginning, as in `crashes`"),
    ("x_m", "float64", "m", "front bumper at the beginning, in the network's coordinates"),
    ("y_m", "float64", "m", "front bumper at the beginning, in the network's coordinates"),
    ("lane", "string", "-", "lane of the front at the beginning; inside junctions it begins with a colon"),
    (
        "verdict",
        "string",
        "-",
        "what it was worth, against a fork of the world without it: `avoided` (a crash), `mitigated`, "
        "`unchanged`, `worsened` (a crash either way), `induced` (a crash), `precautionary` (a near-crash otherwise), "
        "`unneeded`, `unknown`; empty where no verdict was asked for",
    ),
    ("verdict_reason", "string", "-", "why it is unknown; else empty"),
    ("verdict_window_s", "float64", "s", "from its beginning, how long the two worlds are compared"),
    ("acted_by", "string", "-", "what it first acted with on the world: `brake`, or `warning` that the driver heeded"),
    ("acted_s", "float64", "s", "when it did, which is when the two worlds part; null if it did not within the run"),
    *(
        (f"{world}_{name}", dtype, unit, f"{where}: {meaning}")
        for world, where in (("with", "with the intervention"), ("without", "without it"))
        for name, dtype, unit, meaning in _WORLD
    ),
)

_CONFLICTS = _table(
    "conflicts",
    "One row per encounter of two vehicles that came to matter: one closed in on its lead at a TTC below 4 s, two "
    "crossed each other's path within 3 s or at a TTC below 1.5 s, or one braked hard for the other. What is largest "
    "and smallest is so over the steps of the encounter, for crashes until contact.",
    ("conflict_id", "int64", "-", "number within the run, from 0, in the order of their ends"),
    ("kind", "string", "-", "`following` the other on the same path, or `crossing` its path"),
    ("ego", "string", "-", "id of the follower; at crossings of who comes second"),
    ("other", "string", "-", "id of the other vehicle"),
    ("ego_vclass", "string", "-", "SUMO's vehicle class"),
    ("other_vclass", "string", "-", "SUMO's vehicle class"),
    ("ego_equipped", "bool", "-", "it has an AEB"),
    ("other_equipped", "bool", "-", "it has an AEB"),
    ("begin_s", "float64", "s", "first step of it in which a conflict was possible"),
    ("end_s", "float64", "s", "last step of it"),
    ("min_ttc_s", "float64", "s", "smallest time to collision; 0 for crashes, inf for never on a collision course"),
    ("min_ttc2_s", "float64", "s", "smallest second-order time to collision; 0 for crashes, inf for never"),
    ("max_drac_mps2", "float64", "m/s2", "largest deceleration needed of the ego, at a constant speed of the other"),
    (
        "max_required_decel_mps2",
        "float64",
        "m/s2",
        "largest deceleration needed of the ego, at the other's acceleration",
    ),
    ("min_gap_m", "float64", "m", "smallest gap; at crossings smallest distance of the bodies; 0 for crashes"),
    (
        "pet_s",
        "float64",
        "s",
        "post-encroachment time where the paths cross, interpolated inside the step; negative if both were there at "
        "once; null for `following`, for crashes, and if the second was not there within 5 s",
    ),
    ("exposed_s", "float64", "s", "time at a TTC below 1.5 s"),
    (
        "max_decel_mps2",
        "float64",
        "m/s2",
        "largest deceleration of the ego while TTC was below 4 s, by its driver or AEB",
    ),
    (
        "near_crash",
        "bool",
        "-",
        "no contact, but the follower, or either one at crossings, braked by more than 0.5 g at a TTC below 4 s",
    ),
    ("crashed", "bool", "-", "ended in contact of the two"),
    ("secondary", "bool", "-", "one of the two had crashed before"),
    ("ego_error", "string", "-", "last error that its driver made while TTC fell to its smallest, below 4 s"),
    ("other_error", "string", "-", "the same of the other's driver"),
    ("x_m", "float64", "m", "front bumper of the ego at the smallest TTC, in the network's coordinates"),
    ("y_m", "float64", "m", "front bumper of the ego at the smallest TTC, in the network's coordinates"),
)

_EXPOSURE = _table(
    "exposure",
    "Distance and time driven, by vehicle class and AEB system; wrecks do not count.",
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("equipped", "bool", "-", "with an AEB"),
    ("strategy", "string", "-", "AEB system, with `/suite` where not the system's own; empty without"),
    ("vehicles", "int64", "-", "vehicles that departed"),
    ("distance_m", "float64", "m", "distance driven by all of them"),
    ("time_s", "float64", "s", "time on the road of all of them"),
)

_TRAFFIC = _table(
    "traffic",
    "Traffic per interval and vehicle class; wrecks count as standing in distance, time, speed and delay, and not at "
    "all in stops and queues. Queues are defined in `aeb_sumo.ledger.queues` and `.bottlenecks`.",
    ("begin_s", "float64", "s", "start of the interval"),
    ("end_s", "float64", "s", "end of the interval"),
    ("vclass", "string", "-", "SUMO's vehicle class"),
    ("departed", "int64", "-", "vehicles that entered"),
    ("arrived", "int64", "-", "vehicles that reached their destination"),
    ("removed", "int64", "-", "vehicles taken off the road before their destination: wrecks, for the most part"),
    ("pending", "int64", "-", "vehicles that waited for a place to enter, at the end of the interval"),
    ("waiting_s", "float64", "s", "time that vehicles waited for a place to enter, sampled once per second"),
    ("flow_vph", "float64", "1/h", "arrivals per hour"),
    ("vehicles_mean", "float64", "-", "vehicles on the road, mean over the interval"),
    ("distance_m", "float64", "m", "distance driven"),
    ("time_s", "float64", "s", "time on the road"),
    ("speed_mps", "float64", "m/s", "space-mean speed: distance by time; null without vehicles"),
    ("travel_time_s", "float64", "s", "of those that arrived: sum of the times from entering to arriving"),
    (
        "delay_s",
        "float64",
        "s",
        "time lost against driving at the allowed speed, summed up in every step; scheduled stops do not count",
    ),
    ("stops", "int64", "-", "how often one fell below 5 km/h after having been above 10, sampled once per second"),
    ("standing_s", "float64", "s", "time below 5 km/h, but for scheduled stops, sampled once per second"),
    (
        "blocked_s",
        "float64",
        "s",
        "delay of those queued behind a wreck, directly or through the queue, until they are up to speed again, "
        "sampled once per second",
    ),
    (
        "discharged",
        "int64",
        "-",
        "vehicles that entered a lane with a queue before it and none on it, the queue standing since the one before "
        "entered; sampled once per second",
    ),
    ("headway_s", "float64", "s", "time since then, sum over them; discharged by headway_s is the capacity per lane"),
)

_IMPACT: tuple[tuple[str, DType, str, str], ...] = (
    ("impact_speed_mps", "float64", "m/s", "impact speed of the crash; null without one"),
    ("delta_v_mps", "float64", "m/s", "the larger change of velocity of the two in it"),
    ("serious_risk", "float64", "-", "risk that somebody is injured seriously; null where no curve applies"),
)

_CEILINGS = _table(
    "ceilings",
    "One row per crash of a baseline and ceiling: what becomes of it in a fork of the world, made 8 s before, in which "
    "the vehicles whose braking could help have a perfect system, a careful driver, or an AEB to compare with, which "
    "until 3 s before acts on those alone whom they crash with. Empty where no ceilings were asked for.",
    ("crash_id", "int64", "-", "the crash, as in `crashes` of the run"),
    (
        "ceiling",
        "string",
        "-",
        "`perfect` (true states, line of sight, all that the road gives at once), `careful` (the driver of UN R157) or "
        "the AEB system that takes their place",
    ),
    (
        "equipped",
        "string",
        "-",
        "ids of the vehicles that have it, by spaces: motor vehicles, the striker and, but in rear-end crashes, the "
        "struck one; empty for none",
    ),
    ("forked_s", "float64", "s", "when the world was forked; null where it was not"),
    ("braked_s", "float64", "s", "when the first of them began to brake in the fork; null for never"),
    (
        "outcome",
        "string",
        "-",
        "`avoided` (the two do not crash until 6 s after the crash, unless others push them), `mitigated`, `unchanged` "
        "or `worsened` (they do), "
        "`other` (avoided, but one of the equipped has a crash that the baseline does not have) or `unknown`",
    ),
    ("reason", "string", "-", "why it is unknown, or why nobody is equipped; else empty"),
    ("other", "string", "-", "id of whom it crashed with instead, for the outcome `other`; else empty"),
    *(
        (f"{world}_{name}", dtype, unit, f"{where}: {meaning}")
        for world, where in (("with", "in the fork"), ("without", "in the baseline"))
        for name, dtype, unit, meaning in _IMPACT
    ),
)

TABLES: dict[str, Table] = {
    t.name: t for t in (_RUNS, _CRASHES, _INTERVENTIONS, _CONFLICTS, _EXPOSURE, _TRAFFIC, _CEILINGS)
}
"""All tables by name."""
