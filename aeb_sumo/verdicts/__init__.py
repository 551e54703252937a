"""What would have happened otherwise: interventions against a fork of the world in which they do not take place."""

from aeb_sumo.verdicts.book import Verdicts
from aeb_sumo.verdicts.choice import Choice
from aeb_sumo.verdicts.judge import Hit, Outcome, verdict

__all__ = ["Choice", "Hit", "Outcome", "Verdicts", "verdict"]
