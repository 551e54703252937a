"""Many runs: a specification, the runs that it stands for, and their execution, which can be ended and resumed.

SPEC.toml -> `spec` -> `expansion` -> `runner`, which sends every run that is missing to an executor; there `execute`
asks one of the `workers`, processes that have all at hand that runs need: each `worker` simulates one run after the
other, each in a fresh fork of itself, as libsumo holds one world per process.
"""
