"""One HTML page about the runs of a folder, for people: `aeb-sumo report`."""

from analysis.report.page import render

__all__ = ["render"]
