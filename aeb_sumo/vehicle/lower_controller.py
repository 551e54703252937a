"""The PID lower controller of Zhao et al. 2025, 2.2: its gains. The brake runs it (`aeb_sumo.vehicle.brake`)."""

from dataclasses import dataclass

from aeb_sumo.parameters import check, within

__all__ = ["PidParams"]


@dataclass(frozen=True, kw_only=True)
class PidParams:
    """Gains of eq. 7.

    Attributes:
        kp: proportional gain, our assumption: that of a loop with the lag of its plant.
        ti: integral time [s], our assumption: as for `kp`.
        td: derivative time [s], our assumption.
        limit: the controller's output stays within 0 and this [m/s2], our assumption; the integral stops there.

    The source tunes its gains by particle swarm and does not print them; see `for_plant`.
    """

    kp: float = within(1.0, 0.0, 100.0)
    ti: float = within(0.05, 0.001, 100.0)
    td: float = 0.0
    limit: float = within(12.0, 0.1, 100.0)

    def __post_init__(self) -> None:
        """Raises `InputError` for a gain out of range."""
        check(self)

    @classmethod
    def for_plant(cls, *, lag: float, dead_time: float) -> "PidParams":
        """Gains for a first-order lag [s] behind a dead time [s].

        The SIMC rule, from another source (Skogestad 2003, J. Process Control 13, Table 1), with the closed loop as
        fast as the plant allows: `kp = lag / (tau_c + dead_time)`, `ti = lag`, `tau_c = max(lag, dead_time)`. Without
        dead time the loop follows the demand with the lag of the plant itself, within the <= 0.1 s that the published
        results allow (shared/seeds.md A11).
        """
        lag = max(lag, 0.01)
        return cls(kp=lag / (max(lag, dead_time) + dead_time), ti=lag)
