"""What a run leaves behind: the schemas of the tables and the store they live in."""

from aeb_sumo.results.schema import TABLES, VERDICTS, Column, Table
from aeb_sumo.results.store import Results, commit_failure, finished, holds_results, read, write

__all__ = [
    "TABLES",
    "VERDICTS",
    "Column",
    "Results",
    "Table",
    "commit_failure",
    "finished",
    "holds_results",
    "read",
    "write",
]
