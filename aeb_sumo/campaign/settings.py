"""One run of a campaign: its settings as plain values that any process can be told, and what they stand for."""

from dataclasses import asdict, dataclass, field, replace
from os.path import normpath
from pathlib import Path
from typing import Any

from aeb_sumo import scenarios, strategies
from aeb_sumo.drivers import profile
from aeb_sumo.equipment import Equipment, equipment
from aeb_sumo.scenarios import Scenario

__all__ = ["Carried", "Settings", "World", "drivers_of"]


@dataclass(frozen=True, kw_only=True)
class World:
    """What is simulated, without the AEB.

    Attributes:
        root: folder that relative paths count from.
        scenario: a name, or the path of a .sumocfg.
        demand, ebike_share, weather, mu: as in `Scenario.varied`; None for the scenario's.
        drivers: a name, or the path of a .toml; None for the scenario's.
    """

    root: str
    scenario: str
    demand: float | None = None
    ebike_share: float | None = None
    weather: str | None = None
    mu: float | None = None
    drivers: str | None = None

    def make(self) -> Scenario:
        """The scenario. Its name in the tables is the path as it is written, which does not depend on the machine.

        Raises:
            InputError: something is unknown, out of range or means nothing to the scenario.
        """
        drivers = None if self.drivers is None else drivers_of(self.root, self.drivers)
        return _scenario(self.root, self.scenario).varied(
            demand=self.demand, ebike_share=self.ebike_share, weather=self.weather, mu=self.mu, drivers=drivers
        )


@dataclass(frozen=True, kw_only=True)
class Carried:
    """Who has which AEB: a strategy, its sensors and a share, or all in one as text.

    Attributes:
        strategy, sensing, penetration: as in `aeb_sumo.simulate.run`; no strategy where `equip` says it.
        equip: as there; empty for none.
        parameters: of the strategy by name; beside `equip`, `SYSTEM.NAME`.
    """

    strategy: str | None = None
    sensing: str | None = None
    penetration: float | None = None
    equip: str = ""
    parameters: dict[str, Any] = field(default_factory=dict)

    def make(self) -> Equipment:
        """The equipment.

        Raises:
            InputError: something is unknown or out of range.
        """
        if self.equip:
            return Equipment.parse(self.equip, self.parameters)
        system = strategies.load(str(self.strategy), self.parameters)
        return equipment(system, sensing=self.sensing, penetration=self.penetration)


@dataclass(frozen=True, kw_only=True)
class Settings:
    """All that a run depends on.

    Attributes:
        world: what is simulated.
        carried: who has which AEB.
        seed: of SUMO and of the drivers.
        duration_s, step_length_s, blockage_s: None for the scenario's.
        interval_s: of the rows of table `traffic`.
        verdicts: which interventions are judged.
    """

    world: World
    carried: Carried
    seed: int
    duration_s: float | None
    step_length_s: float | None
    blockage_s: float | None
    interval_s: float
    verdicts: str

    def plain(self) -> dict[str, Any]:
        """As what JSON can hold."""
        return asdict(self)

    @classmethod
    def of(cls, plain: dict[str, Any]) -> "Settings":
        """From what `plain` gave."""
        return cls(**{**plain, "world": World(**plain["world"]), "carried": Carried(**plain["carried"])})


def _scenario(root: str, name: str) -> Scenario:
    if len(Path(name).parts) == 1 and not Path(name).suffix:
        return scenarios.load(name)
    return replace(scenarios.from_sumocfg(Path(root) / name), name=normpath(name))


def drivers_of(root: str, name: str) -> profile.Profile:
    """A driver profile; its name in the tables is the path as it is written.

    Raises:
        InputError: there is none.
    """
    if not name.endswith(".toml"):
        return profile.load(name)
    return replace(profile.load(str(Path(root) / name)), name=normpath(name))
