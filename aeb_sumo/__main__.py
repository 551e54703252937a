"""`python -m aeb_sumo` is the `aeb-sumo` command."""

from aeb_sumo.cli import main

main()
