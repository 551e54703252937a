"""`aeb-sumo compare` and `aeb-sumo tables`."""

import click
from rich.table import Table

import analysis
from aeb_sumo.cli.show import console, print_effect, print_frame, print_groups, print_pairs, print_summary
from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES

__all__ = ["compare", "tables"]

_PRICED = ("delay", "flow", "mean speed")  # of the effect, which the price has too


@click.command()
@click.argument("folder")
@click.argument("other", required=False)
def compare(folder: str, other: str | None) -> int:
    """Print the figures of one or two results folders, or fsspec URLs, side by side."""
    # Two folders of the same name still need two names.
    names = [folder] if other is None else [folder, other if other != folder else f"{other} (again)"]
    data = {name: analysis.load(path) for name, path in zip(names, (folder, other), strict=False) if path is not None}
    if other is None:
        print_summary(analysis.summary(data[names[0]]), names[0])
    else:
        print_summary(analysis.compare(**data), " | ".join(names))
    for name, each in data.items():
        if count := len(each.died):
            reasons = ", ".join(sorted(set(each.died["reason"])))
            click.echo(f"aeb-sumo: note: {name}: {count} runs died or hung and count nowhere: {reasons}", err=True)
        if each.count("interventions"):
            print_frame(analysis.intervention_statistics(each), f"{name}: interventions")
        quality = analysis.precision_recall(each)
        if len(quality):
            print_frame(quality, f"{name}: how many interventions were needed, how many crashes avoided")
            print_groups(analysis.verdict_rates(each), f"{name}: verdicts per 1,000 km")
            print_groups(analysis.passed_on(each), f"{name}: hard braking passed on to those behind")
        if {"none"} < set(each.runs["strategy"]):
            try:
                print_pairs(analysis.pair_counts(each), f"{name}: what became of the crashes of the baseline, by seed")
                crashes = analysis.effect(each).drop(index=list(_PRICED), level="figure")
                print_effect(crashes, f"{name}: what the AEB changes, by seed")
                print_effect(analysis.traffic_price(each), f"{name}: price for the traffic, by seed")
            except InputError as error:
                click.echo(f"aeb-sumo: note: {name} has no pairs of runs: {error}", err=True)
    return 0


@click.command()
@click.argument("table", required=False)
def tables(table: str | None) -> int:
    """Print the columns of TABLE, or of all tables, with type, unit and meaning."""
    if table is not None and table not in TABLES:
        raise InputError(f"unknown table {table!r}; there are: {', '.join(TABLES)}")
    for each in TABLES.values() if table is None else (TABLES[table],):
        grid = Table("column", "type", "unit", "meaning", title=f"{each.name}: {each.meaning}", title_justify="left")
        for column in each.columns:
            grid.add_row(column.name, column.dtype, column.unit, column.meaning)
        console().print(grid)
    return 0
