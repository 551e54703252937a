"""The definitions that the numbers rest on."""

from aeb_sumo.results import VERDICTS
from analysis.report.parts import Section

__all__ = ["section"]

_ALWAYS = (
    ("crash", "The oriented boxes of two vehicles touch while they approach each other, on lanes that have to do with "
     "each other; swept through the step, so instant and speeds are interpolated. One crash per pair of vehicles, at "
     "first contact."),
    ("secondary crash", "One of the two vehicles had crashed before. All others are primary."),
    ("impact speed", "Magnitude of the relative velocity of the two vehicles at contact."),
    ("serious injuries expected", "Sum of the risks that a person is injured seriously (MAIS3+) or dies, by published "
     "curves; there are curves only for persons whom the front of a passenger car hit, so the sum is a lower bound."),
    ("intervention", "From an AEB's first warning or braking until it has been doing neither for 1 s. Its phase is the "
     "highest one reached: warning alone, partial or full braking."),
    ("TTC", "Time to collision: gap by closing speed; bumper to bumper for a lead, for crossing traffic along the own "
     "path to where the paths cross. Infinite when the gap is not closing."),
    ("speed reduction", "Own speed at the first braking less the lowest speed after it."),
    ("avoided, net", "Crashes without AEB less crashes with it, in runs of the same seed, settings and time span. New "
     "crashes count against it. Drivers draw the same random numbers in both, but once traffic differs it may meet "
     "other situations: that is why the seed is the unit of the intervals."),
    ("delay", "Time lost against driving at the allowed speed, sampled once per second."),
    ("95 % interval", "Of estimates made this way from as many seeds, 95 % of the intervals contain what endless runs "
     "of this simulation would give. It says nothing of how near the simulation is to the road."),
)  # fmt: skip
_VERDICTS = (
    ("verdict", "When an intervention first acts on the world, because the brake bites or the driver heeds the "
     "warning, the simulated world is forked. In the fork this one intervention is suppressed and the world runs on, "
     "all else being equal, drivers' reactions included. The verdict compares what happened to the vehicle and the "
     "three behind it, from the beginning of the intervention on for 10 s, with what happened there."),
    ("precision, recall", "Precision: share of the judged interventions that avoided or mitigated a crash. Recall: "
     "share avoided of the crashes that vehicles with an AEB would have struck."),
    ("near-crash", "No contact, but braking above 0.5 g at a TTC below 4 s; on a road of friction below 0.56, above "
     "90 % of what it gives."),
)  # fmt: skip


def section(*, verdicts: bool) -> Section:
    """Terms with their definitions.

    Args:
        verdicts: also those of verdicts.
    """
    meanings = [(name, f"{meaning[0].upper()}{meaning[1:]}.") for name, meaning in VERDICTS.items()]
    terms = [*_ALWAYS, *_VERDICTS, *meanings] if verdicts else _ALWAYS
    return Section(id="definitions", title="Definitions", terms=terms)
