"""Rates of rare events with exact intervals."""

from dataclasses import dataclass

from statsmodels.stats.rates import confint_poisson

__all__ = ["Rate", "poisson_rate"]


@dataclass(frozen=True)
class Rate:
    """Events per exposure with its confidence interval."""

    rate: float
    low: float
    high: float


def poisson_rate(count: int, exposure: float, confidence: float = 0.95) -> Rate:
    """Rate of a Poisson process with the exact central interval (Garwood 1936; statsmodels `exact-c`).

    Args:
        count: events seen, >= 0.
        exposure: what they are counted over, for example vehicle-km; without exposure nothing is known.
        confidence: of the interval, 0 to 1.

    Returns:
        The rate per unit of exposure; NaN and an interval from 0 to inf when the exposure is 0.

    Raises:
        ValueError: a negative count or exposure, or a confidence outside 0..1.
    """
    if count < 0 or exposure < 0 or not 0 < confidence < 1:
        raise ValueError(f"count {count} and exposure {exposure} must be >= 0, confidence {confidence} within 0..1")
    if exposure == 0:
        return Rate(float("nan"), 0.0, float("inf"))
    low, high = confint_poisson(count, exposure, method="exact-c", alpha=1 - confidence)
    return Rate(count / exposure, max(float(low), 0.0), float(high))
