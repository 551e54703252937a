"""The books of a run: interventions, conflicts, exposure and traffic, as rows of the tables in `aeb_sumo.results`."""
