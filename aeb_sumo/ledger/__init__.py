"""The books of a run: interventions, exposure and traffic, as rows of the tables in `aeb_sumo.results`."""
