"""Who has which AEB: shares of the vehicles, by kind, that carry a system and its sensors."""

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import fsum, nan
from typing import Any, Self

from aeb_sumo import strategies
from aeb_sumo.drivers.streams import number, stream
from aeb_sumo.errors import InputError
from aeb_sumo.parameters import differences
from aeb_sumo.perception.suites import Suite, suite
from aeb_sumo.strategies.base import Strategy
from aeb_sumo.world.kinds import VClasses

__all__ = ["Equipment", "Share", "System", "equipment"]

_FORM = "[KIND:]SYSTEM[/SUITE]=SHARE, for example zhao2025=0.3 or truck:zhao2025/radar=0.2"
_ROUNDING = 1e-9  # that a sum of shares may be above 1
_CARS = ""  # the kind that stands for all cars


@dataclass(frozen=True)
class System:
    """An AEB as it is built into a vehicle: a strategy and the sensors it works with."""

    strategy: Strategy
    suite: Suite

    @classmethod
    def of(cls, strategy: str | Strategy, sensing: str | Suite | None = None) -> Self:
        """A system from names; without `sensing` it sees with what it was published with.

        Raises:
            InputError: there is no such strategy or suite.
        """
        brain = strategies.load(strategy) if isinstance(strategy, str) else strategy
        return cls(brain, sensing if isinstance(sensing, Suite) else suite(sensing or brain.sensing))

    @property
    def name(self) -> str:
        """The strategy's name, and `/SUITE` behind it where that is not the strategy's own."""
        own = self.suite.name == self.strategy.sensing
        return self.strategy.name if own else f"{self.strategy.name}/{self.suite.name}"


@dataclass(frozen=True, kw_only=True)
class Share:
    """So many of the vehicles of one kind carry this system.

    Attributes:
        kind: a vehicle type or a vehicle class of SUMO; empty for all cars (`VClasses.CARS`).
        share: 0 to 1.
    """

    kind: str = _CARS
    system: System
    share: float

    def __post_init__(self) -> None:
        """Raises `InputError` for a share out of range, or of nothing."""
        if not 0 <= self.share <= 1:
            raise InputError(f"the share of {self._left} must lie within 0..1, not {self.share:g}")
        if self.system.strategy.name == "none":
            raise InputError(f"{self._left!r} equips nobody; leave it out, or give another system the share 0")

    @property
    def _left(self) -> str:
        return f"{self.kind}:{self.system.name}" if self.kind else self.system.name

    @property
    def text(self) -> str:
        """As on the command line; the number reads back as the same."""
        return f"{self._left}={repr(abs(float(self.share))).removesuffix('.0')}"


@dataclass(frozen=True)
class Equipment:
    """Shares of the vehicles that carry an AEB, and which.

    What is said of a vehicle's type holds before what is said of its class, and that before what is said of all cars.
    Each vehicle has one number of its own, uniform within 0..1, and the shares of its kind are laid end to end from 0
    in canonical order: by the names of the systems. So the order in which they are given does not matter; a vehicle
    that has a system at one share of it has it at every larger one, the other shares being equal; and no vehicle is
    without an AEB at a larger share that has one at a smaller.

    Attributes:
        shares: in canonical order, by kind and system; none of them: the baseline.
    """

    shares: tuple[Share, ...] = ()

    def __post_init__(self) -> None:
        """Raises `InputError` when shares add up to more than 1, or a system is named twice or means two things."""
        ordered = tuple(sorted(self.shares, key=lambda s: (s.kind, s.system.name)))
        object.__setattr__(self, "shares", ordered)
        for one, two in pairwise(ordered):
            if (one.kind, one.system.name) == (two.kind, two.system.name):
                raise InputError(f"equipment names {one.text.rpartition('=')[0]!r} twice")
        for kind in self.kinds:
            total = fsum(s.share for s in ordered if s.kind == kind)
            if total > 1 + _ROUNDING:
                raise InputError(f"shares of {kind or 'cars'} must add up to 1 at most, not {total:g}: {self.text}")
        systems = {s.system.name: s.system for s in ordered}
        for one in ordered:
            if one.system != systems[one.system.name]:
                raise InputError(f"two systems of one name, {one.system.name!r}, cannot be told apart in the tables")

    @classmethod
    def single(
        cls, strategy: str | Strategy, sensing: str | Suite | None = None, *, penetration: float = 1.0
    ) -> "Equipment":
        """One system in a share of the cars; the strategy "none" is the baseline.

        Raises:
            InputError: strategy or suite are unknown, or the share is out of range.
        """
        if not 0 <= penetration <= 1:
            raise InputError(f"penetration must lie within 0..1, not {penetration:g}")
        system = System.of(strategy, sensing)
        return cls() if system.strategy.name == "none" else cls((Share(system=system, share=penetration),))

    @classmethod
    def parse(cls, text: str, parameters: Mapping[str, Any] | None = None) -> "Equipment":
        """From text: `[KIND:]SYSTEM[/SUITE]=SHARE`, several of them with commas between.

        KIND is a vehicle type or a vehicle class of SUMO, all cars without it; SUITE the system's own without it.

        Args:
            text: for example `zhao2025=0.3,yan2025=0.2` or `passenger:zhao2025=0.5,truck:zhao2025/radar=0.2`.
            parameters: of the strategies, by name: `zhao2025.comfort_decel` -> value, or nested.

        Raises:
            InputError: the text cannot be read, a system, suite or parameter is unknown, or a share is out of range.
        """
        entries = [_entry(part.strip()) for part in text.split(",")]
        own = _by_strategy(parameters or {}, sorted({entry.strategy for entry in entries}))
        return cls(tuple(e.share(strategies.load(e.strategy, own.get(e.strategy))) for e in entries))

    @property
    def systems(self) -> tuple[System, ...]:
        """Each system once, in the order of their names."""
        by_name = {s.system.name: s.system for s in self.shares}
        return tuple(by_name[name] for name in sorted(by_name))

    @property
    def kinds(self) -> frozenset[str]:
        """Kinds of vehicles of which something is said; the empty one is all cars."""
        return frozenset(s.kind for s in self.shares)

    @property
    def text(self) -> str:
        """As on the command line, in canonical order; equal texts and parameters equip the same vehicles alike."""
        return ",".join(s.text for s in self.shares)

    @property
    def _mixed(self) -> bool:
        return len(self.shares) > 1 or not self.kinds <= {_CARS}

    @property
    def name(self) -> str:
        """For people and for `runs.strategy`: `none`, the one strategy that cars have, or the text of a mix."""
        if self._mixed:
            return self.text
        return self.shares[0].system.strategy.name if self.shares else "none"

    @property
    def sensing(self) -> str:
        """The suites, joined by +."""
        return "+".join(sorted({s.suite.name for s in self.systems}))

    @property
    def parameters(self) -> str:
        """Where they differ from the defaults, `name=value` with spaces between; of a mix, `system.name=value`."""
        prefixes = [f"{s.name}." if self._mixed else "" for s in self.systems]
        return " ".join(
            prefix + part
            for prefix, system in zip(prefixes, self.systems, strict=True)
            for part in differences(system.strategy).split()
        )

    @property
    def penetration(self) -> float:
        """Share of the cars with an AEB of any kind; nan where that depends on their types."""
        return fsum(s.share for s in self.shares) if self.kinds <= {_CARS} else nan

    @property
    def folder(self) -> str:
        """Its name as part of a path."""
        name = self.text if self._mixed else self.systems[0].name if self.shares else "none"
        return re.sub(r"[^A-Za-z0-9._-]+", "_", name)[:80]

    def run_id(self, scenario: str, seed: int) -> str:
        """Name of a run with this equipment, safe as that of a file."""
        share = "" if self._mixed else f"-p{self.penetration:g}"
        # Not every mix can be told from every other by what a path may hold.
        digest = f"-{number(0, self.text, self.parameters):016x}"[:9] if self._mixed or self.parameters else ""
        return f"{scenario}-{self.folder}{share}{digest}-s{seed}"

    @property
    def types(self) -> frozenset[str]:
        """Of the kinds those that can only be vehicle types."""
        return self.kinds - VClasses.ALL - {_CARS}

    def check_kinds(self, types: Collection[str]) -> None:
        """Check that every kind exists, as a class or as one of these vehicle types.

        Raises:
            InputError: one does not.
        """
        for kind in sorted(self.types - set(types)):
            there = ", ".join(sorted(t for t in types if not t.startswith("DEFAULT_"))) or "none"
            raise InputError(
                f"equipment of {kind!r}, which is no vehicle class and no vehicle type that SUMO has read so far; "
                f"types: {there}"
            )

    def of(self, vehicle: str, *, vtype: str, vclass: str, seed: int) -> System | None:
        """The system that a vehicle carries.

        Args:
            vehicle: its id.
            vtype: its vehicle type.
            vclass: its vehicle class.
            seed: of the run.
        """
        kinds = (vtype, vclass, *([_CARS] if vclass in VClasses.CARS else ()))
        kind = next((k for k in kinds if k in self.kinds), None)
        if kind is None:
            return None
        draw, edge = stream(seed, "equip", vehicle).random(), 0.0
        for one in self.shares:
            if one.kind == kind:
                edge += one.share
                if draw < edge:
                    return one.system
        return None


def equipment(
    strategy: str | Strategy | None = None,
    *,
    sensing: str | Suite | None = None,
    penetration: float | None = None,
    equip: "str | Equipment | None" = None,
) -> Equipment:
    """What a run equips its vehicles with: one system in a share of the cars, or as `equip` says.

    Raises:
        InputError: both are given, or something is unknown or out of range.
    """
    if equip is None:
        single = 1.0 if penetration is None else penetration
        return Equipment.single("zhao2025" if strategy is None else strategy, sensing, penetration=single)
    given = {"strategy": strategy, "sensing": sensing, "penetration": penetration}
    if also := [name for name, value in given.items() if value is not None]:
        raise InputError(f"equip says who has which system and sensors; it excludes {', '.join(also)}")
    return Equipment.parse(equip) if isinstance(equip, str) else equip


@dataclass(frozen=True, kw_only=True)
class _Entry:
    """One `[KIND:]SYSTEM[/SUITE]=SHARE`, as it is written."""

    kind: str
    strategy: str
    sensing: str
    number: float

    def share(self, strategy: Strategy) -> Share:
        return Share(kind=self.kind, system=System.of(strategy, self.sensing or None), share=self.number)


def _entry(text: str) -> _Entry:
    left, _, value = text.rpartition("=")
    kind, colon, system = left.rpartition(":")
    name, slash, sensing = (part.strip() for part in system.partition("/"))
    kind, value = kind.strip(), value.strip()
    if not name or not value or bool(colon) != bool(kind) or bool(slash) != bool(sensing):
        raise InputError(f"cannot read {text!r} in the equipment; write {_FORM}")
    try:
        return _Entry(kind=kind, strategy=name, sensing=sensing, number=float(value))
    except ValueError:
        raise InputError(f"the share of {left.strip()} must lie within 0..1, not {value!r}") from None


def _by_strategy(parameters: Mapping[str, Any], names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Parameters of each strategy, from `zhao2025.comfort_decel` -> value or from nested mappings."""
    result: dict[str, dict[str, Any]] = {}
    for path, value in parameters.items():
        name, _, rest = path.partition(".")
        if name not in names or not (rest or isinstance(value, Mapping)):
            raise InputError(f"parameter {path!r} of which system? Write SYSTEM.PARAMETER; here: {', '.join(names)}")
        result.setdefault(name, {}).update({rest: value} if rest else value)
    return result
