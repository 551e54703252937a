"""What reading a large campaign takes: 100 runs of 100,000 interventions, 10 million rows; time and peak memory.

    python tests/benchmarks/large.py FOLDER [RUNS]

The rows are those of a short run on the highway, with verdicts, over and over, with ids, times and places of their own,
so that the files are as large as real ones. FOLDER is filled at the first call, and kept. Each question is asked in a
process of its own; the memory that a process has before it asks is said as well.
"""

import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pyarrow as pa

import analysis
from aeb_sumo import scenarios
from aeb_sumo.results import VERDICTS, finished
from aeb_sumo.results.writer import Writer
from aeb_sumo.simulate import run

ROWS = 100_000
SYSTEMS = ("zhao2025", "staged", "yan2025", "lin2021")
QUESTIONS = {
    "load": "data.runs",
    "verdict counts by strategy, two columns": "data.read('interventions', ['strategy', 'verdict']).value_counts()",
    "analysis.verdict_counts(data, 'strategy')": "analysis.verdict_counts(data, 'strategy')",
    "one filter: precautionary, all columns": "data.read('interventions', filters=[('verdict', '==', 'avoided')])",
    "one filter: a minute of time, three columns": (
        "data.read('interventions', ['vehicle', 'begin_s', 'verdict'], [('begin_s', '<', 60.0)])"
    ),
    "runs of one strategy, one column": "chosen.read('interventions', ['verdict'])",
    "analysis.summary(data)": "analysis.summary(data)",
    "analysis.intervention_statistics(data)": "analysis.intervention_statistics(data)",
    "analysis.precision_recall(data)": "analysis.precision_recall(data)",
}


def make(folder: str, runs: int) -> None:
    """Clone a run."""
    real = run(scenarios.load("highway"), "zhao2025", seed=1, duration=60, verdicts="all")
    rows, draw = real.tables["interventions"].drop_columns("run_id"), np.random.default_rng(1)
    picked = pa.array(np.arange(ROWS) % len(rows))
    for k in range(runs):
        many, run_id, system = rows.take(picked), f"clone-{k:05d}", SYSTEMS[k % len(SYSTEMS)]
        begin = np.sort(draw.uniform(0, 36_000, ROWS)).round(1)
        own = {
            "intervention_id": np.arange(ROWS),
            "vehicle": [f"flow.{v}" for v in draw.integers(0, 50_000, ROWS)],
            "strategy": [system] * ROWS,
            "begin_s": begin,
            "end_s": begin + 1,
            "verdict": draw.choice(list(VERDICTS), ROWS),
            "x_m": draw.uniform(0, 5_000, ROWS),
            "warn_gap_m": draw.uniform(0, 50, ROWS),
            "trigger_ttc_s": draw.uniform(0, 3, ROWS),
        }
        for name, values in own.items():
            at = many.schema.get_field_index(name)
            many = many.set_column(at, many.schema.field(at), pa.array(values))
        with Writer(folder, run_id) as writer:
            for name, table in (real.tables | {"interventions": many}).items():
                if name != "runs":
                    for batch in table.select([c for c in table.column_names if c != "run_id"]).to_batches():
                        writer.put(name, batch)
            (row,) = real.tables["runs"].drop_columns("run_id").to_pylist()
            writer.commit(row | {"strategy": system, "seed": k // len(SYSTEMS)})


def ask(folder: str, question: str) -> None:
    """Time and memory of one question."""
    before, begin = _peak(), time.perf_counter()
    data = analysis.load(folder)
    chosen = analysis.load(folder, filters=[("strategy", "==", "zhao2025")]) if "chosen" in question else None
    answer = eval(question, {"analysis": analysis, "data": data, "chosen": chosen})  # noqa: S307
    spent = time.perf_counter() - begin
    print(f"{spent:7.1f} s  {_peak():8,.0f} MB ({before:,.0f} before)  {len(answer):10,} rows", flush=True)


def _peak() -> float:
    """Of this process alone [MB]; what `getrusage` says has that of the one that started it in it."""
    (line,) = (line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM:"))
    return int(line.split()[1]) / 1024


def main() -> None:
    folder, *more = sys.argv[1:]
    if more and not more[0].isdigit():
        return ask(folder, QUESTIONS[more[0]])
    runs = int(more[0]) if more else 100
    if len(finished(folder)) < runs:
        begin = time.perf_counter()
        make(folder, runs)
        size = sum(path.stat().st_size for path in Path(folder).rglob("*.parquet")) / 1e6
        print(f"{runs * ROWS:,} rows written in {time.perf_counter() - begin:.0f} s, {size:,.0f} MB")
    for question in QUESTIONS:
        print(f"{question:48}", end=" ", flush=True)
        subprocess.run([sys.executable, __file__, folder, question], check=True)
    return None


if __name__ == "__main__":
    main()
