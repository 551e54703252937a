"""From a specification to its runs, each with its id; whatever can be wrong with them is found here."""

from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from itertools import product
from pathlib import Path
from typing import Any

from aeb_sumo import strategies
from aeb_sumo.campaign.identity import Fitted, Known, content, known, run_id
from aeb_sumo.campaign.settings import Carried, Settings, World, drivers_of
from aeb_sumo.campaign.spec import Spec
from aeb_sumo.campaign.vehicle_types import vehicle_types
from aeb_sumo.equipment import Equipment
from aeb_sumo.errors import InputError
from aeb_sumo.perception.suites import suite

__all__ = ["Job", "expand"]

_VARIATIONS = ("demand", "ebike_share", "weather", "mu", "drivers")


@dataclass(frozen=True, kw_only=True)
class Job:
    """One run.

    Attributes:
        run_id: its name in all tables.
        settings: what it is of.
        content: what went into the id.
        limit_s: wall time after which it is killed.
        span: simulated time [s]; None until all vehicles have arrived.
    """

    run_id: str
    settings: Settings
    content: Mapping[str, Any]
    limit_s: float
    span: float | None

    @classmethod
    def of(cls, world: Known, carried: Fitted, settings: Settings, limit_s: float) -> "Job":
        """The job of some settings, which are those of this world and equipment."""
        made_of = content(world, carried, settings)
        return cls(
            run_id=run_id(world, carried, settings.seed, made_of),
            settings=settings,
            content=made_of,
            limit_s=limit_s,
            span=settings.duration_s or world.span,
        )

    def changed(self, **settings: Any) -> "Job":
        """The job with other settings, those of world and equipment excepted."""
        new = replace(self.settings, **settings)
        return Job.of(known(new.world.make()), Fitted(new.carried.make()), new, self.limit_s)

    @property
    def group(self) -> str:
        """Name of the runs that differ in seed alone."""
        label = self.run_id.rpartition("-")[0].removesuffix(f"-s{self.settings.seed}")
        parameters = str(self.content["parameters"])
        return f"{label} {parameters}" if parameters else label


def expand(spec: Spec) -> list[Job]:
    """All runs of a specification, each once.

    The seed changes slowest, so that a campaign that is not finished has all worlds at some seeds. The baseline knows
    nothing of sensors, shares and parameters, and is one run per seed and world. Runs that are the same, as
    `equip = "zhao2025=1"` beside `strategy = "zhao2025"`, are one.

    Raises:
        InputError: something is unknown, out of range or does not fit together; the message names file and key.
    """
    worlds = [(world, known(made)) for world, made in _worlds(spec)]
    systems = [(carried, Fitted(carried.make())) for carried in _checked_systems(spec)]
    _check_types(spec, [made for _, made in worlds], [each.equipment for _, each in systems])
    jobs: dict[str, Job] = {}
    for seed in spec.factors.get("seed", (None,)):
        for (world, made), (carried, equip) in product(worlds, systems):
            job = _job(spec, world, made, carried, equip, made.seed if seed is None else seed)
            jobs.setdefault(job.run_id, job)
    return list(jobs.values())


def _job(spec: Spec, world: World, made: Known, carried: Carried, equip: Fitted, seed: int) -> Job:
    common = asdict(spec.common)
    limit = common.pop("limit_s")
    settings = Settings(world=world, carried=carried, seed=seed, **common)
    blockage = settings.blockage_s
    if blockage is not None and blockage > made.teleport_after:
        raise InputError(
            f"{spec.path}: [run] blockage_s {blockage:g} is too long for {world.scenario}; "
            f"allowed: its time-to-teleport, {made.teleport_after:g} s, or less"
        )
    return Job.of(made, equip, settings, limit)


def _worlds(spec: Spec) -> Iterator[tuple[World, Any]]:
    root = str(spec.path.parent.absolute())
    for name in spec.factors.get("drivers", ()):
        with _naming(spec, "drivers"):
            drivers_of(root, name)
    for scenario in spec.factors["scenario"]:
        with _naming(spec, "scenario"):
            known(World(root=root, scenario=scenario).make())
        for key in _VARIATIONS:  # each by itself, so that the message can name it
            for value in spec.factors.get(key, ()):
                with _naming(spec, key):
                    World(root=root, scenario=scenario, **{key: value}).make()
        for values in product(*(spec.factors.get(key, (None,)) for key in _VARIATIONS)):
            world = World(root=root, scenario=scenario, **dict(zip(_VARIATIONS, values, strict=True)))
            yield world, world.make()


def _checked_systems(spec: Spec) -> list[Carried]:
    factors, parameters = spec.factors, spec.parameters
    for name in factors.get("strategy", ()):
        with _naming(spec, "strategy"):
            strategies.load(name)
    for name in factors.get("sensing", ()):
        with _naming(spec, "sensing"):
            suite(name)
    used = set(factors.get("strategy", ()))
    for text in factors.get("equip", ()):
        with _naming(spec, "equip"):
            used |= {s.strategy.name for s in Equipment.parse(text).systems}
    for system, values in parameters.items():
        if system not in used:
            there = ", ".join(sorted(used))
            raise InputError(f"{spec.path}: [set.{system}] is of no system in [factors]; allowed: {there}")
        for name, each in ((n, v) for n, some in values.items() for v in some):
            with _naming(spec, name, f"set.{system}"):
                strategies.load(system, {name: each})
    systems = list(_systems(spec))
    for carried in systems:
        with _naming(spec, "equip" if carried.equip else "strategy"):
            carried.make()
    return systems


def _check_types(spec: Spec, worlds: Iterable[Known], systems: Iterable[Equipment]) -> None:
    """Vehicle types that equipment names are there; only SUMO knows the types of a scenario."""
    naming = [each for each in systems if each.types]
    for world in worlds if naming else ():
        try:
            there = vehicle_types(world.scenario)
        except InputError:  # each of its runs will say so
            continue
        for equipment in naming:
            with _naming(spec, "equip"):
                equipment.check_kinds(there)


def _systems(spec: Spec) -> Iterator[Carried]:
    factors = spec.factors
    for strategy in factors.get("strategy", ()):
        if strategy == "none":
            yield Carried(strategy=strategy)
            continue
        kinds = product(factors.get("sensing", (None,)), factors.get("penetration", (None,)))
        for (sensing, share), parameters in product(kinds, _settings_of(spec.parameters.get(strategy, {}))):
            yield Carried(strategy=strategy, sensing=sensing, penetration=share, parameters=parameters)
    for text in factors.get("equip", ()):
        inside = {s.strategy.name for s in Equipment.parse(text).systems}
        named = {
            f"{system}.{name}": values
            for system, some in spec.parameters.items()
            for name, values in some.items()
            if system in inside
        }
        for parameters in _settings_of(named):
            yield Carried(equip=text, parameters=parameters)


def _settings_of(values: Mapping[str, Iterable[Any]]) -> Iterator[dict[str, Any]]:
    """Every combination of the values of some parameters; one empty one of none."""
    for chosen in product(*values.values()):
        yield dict(zip(values, chosen, strict=True))


@contextmanager
def _naming(spec: Spec, key: str, table: str = "factors") -> Iterator[None]:
    """What is wrong inside is said to be of a key of the file."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{Path(spec.path)}: [{table}] {key}: {error}") from None
