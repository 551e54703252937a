"""Sensor suites by name: what an equipped vehicle sees with, and how it makes tracks of it.

The radar and the camera of cars M and N and the detection model are equivalent parameters: the source (source 002,
shared/seeds.md 3) prints the results of its measurements and nothing of what is inside its sensors.
"""

from dataclasses import dataclass

from aeb_sumo.errors import InputError
from aeb_sumo.parameters import check, within
from aeb_sumo.perception.crossing import MARGIN
from aeb_sumo.perception.sensor import Sensor

__all__ = ["CAMERA", "RADAR", "SUITES", "Suite", "suite"]


_FRAMES = 63  # that a track remembers


@dataclass(frozen=True, kw_only=True)
class Suite:
    """Sensors and the tracker behind them.

    Attributes:
        name: as on the command line.
        sensors: a target counts as detected in a frame when one of them detects it; none: an ideal suite, which sees
            everything in view as it is.
        persist: ideal suites: a target counts once it has been in view without a gap for this long; all suites: so
            long must a crossing conflict last [s], our assumption.
        search: a target that is new, or with which no conflict was possible, is looked for once in so long, at a phase
            of every vehicle's own; else it is watched in every step (`aeb_sumo.world.leads`) [s], our assumption.
        cycle: time between frames [s], our assumption (automotive radar and camera: 40 to 60 ms).
        confirm: a track counts once it has been detected in so many of so many frames (M of N), our assumption.
        coast: and until it has not been detected for so many frames in a row, our assumption.
        latency: age of what the tracker works on, to the nearest step of the simulation; its output is extrapolated
            to the present [s], our assumption.
        sure: a track counts only while its rate is known this well, standard deviation [m/s], our assumption.
        view: ideal suites: full angle of what they see [deg]; 70 from another source (Sui et al. 2021, reference AEB
            for two-wheelers).
        ahead_of: an own path is clear when the vehicle will have crossed it this long before the other comes [s], our
            assumption: `aeb_sumo.perception.crossing.MARGIN`.
        manoeuvre: standard deviation of the jerk that the tracker expects of a target [m/s3], our assumption.
    """

    name: str
    sensors: tuple[Sensor, ...] = ()
    persist: float = 0.2
    search: float = within(0.2, 0.001, 10.0)
    cycle: float = 0.05
    confirm: tuple[int, int] = (3, 5)
    coast: int = 4
    latency: float = 0.0
    manoeuvre: float = 5.0
    sure: float = 0.5
    view: float = within(70.0, 1.0, 360.0)
    ahead_of: float = MARGIN

    @property
    def reach(self) -> float:
        """The farthest that any of them sees [m]; ideal suites: 150, our assumption (long-range radar)."""
        return max((sensor.reach for sensor in self.sensors), default=150.0)

    @property
    def field_of_view(self) -> float:
        """The widest that any of them sees, full angle [deg]; ideal suites: `view`."""
        return max((sensor.field_of_view for sensor in self.sensors), default=self.view)

    def __post_init__(self) -> None:
        """Raises `InputError` for a parameter out of range."""
        check(self)
        if self.cycle <= 0 or not 0 < self.confirm[0] <= self.confirm[1] <= _FRAMES or not 0 < self.coast <= _FRAMES:
            raise InputError(f"Suite {self.name}: cycle must be above 0 s, confirm and coast within 1 .. {_FRAMES}")


RADAR = Sensor(
    reach=150.0,  # our assumption
    field_of_view=70.0,  # our assumption: as the ideal suite
    range_noise=0.10,  # our assumption
    rate_noise=0.05,  # our assumption
    lateral_noise=0.30,  # our assumption
    detect=((0.0, 8.0), (0.5, 10.63), (0.75, 120.0), (1.0, 150.0)),  # our assumption: calibrated
    lost=(2.48, 9.08),  # our assumption: calibrated
    lost_overlap=0.6,  # our assumption
)
"""The millimetre-wave radar of both cars; detection at 50 % overlap calibrated to Table 2, car M."""

CAMERA = Sensor(
    reach=120.0,  # our assumption
    field_of_view=52.0,  # from another source: Yan et al. 2025, 3 (printed there)
    range_noise=0.5,  # our assumption
    rate_noise=0.10,  # our assumption: how fast the image grows
    lateral_noise=0.05,  # our assumption
    detect=((0.0, 8.0), (0.5, 14.93), (0.75, 100.0), (1.0, 120.0)),  # our assumption: calibrated
)
"""The mono camera of car N; detection at 50 % overlap calibrated to Table 2."""

SUITES: dict[str, Suite] = {
    s.name: s
    for s in (
        Suite(name="ideal"),
        Suite(name="radar", sensors=(RADAR,), latency=0.05),
        Suite(name="camera", sensors=(CAMERA,), latency=0.05),
        Suite(name="fusion", sensors=(RADAR, CAMERA), latency=0.05),
        Suite(name="perfect", persist=0.0, view=360.0, ahead_of=0.0),
    )
}
"""All suites by name; `perfect` sees whoever is in line of sight, all around and at once."""


def suite(name: str) -> Suite:
    """A suite by name.

    Raises:
        InputError: there is none of that name.
    """
    if name not in SUITES:
        raise InputError(f"unknown sensing {name!r}; there are: {', '.join(SUITES)}")
    return SUITES[name]
