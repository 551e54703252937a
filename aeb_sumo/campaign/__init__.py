"""Many runs: a specification, the runs that it stands for, and their execution, which can be ended and resumed.

SPEC.toml -> `spec` -> `expansion` -> `runner`, which sends every run that is missing to an executor; there `execute`
starts a `worker`, a fresh process per run, as libsumo holds one world per process.
"""
