"""Which rows of a table: `[(column, operator, value), ...]`, all of which hold.

The operators are `==`, `!=`, `<`, `<=`, `>`, `>=`, `in` and `not in`; these two take a list of values. A list of such
lists is for rows for which one of them holds. A row in which the column is null, or unknown (NaN), never matches.
"""

from collections.abc import Callable, Sequence
from typing import Any

import pyarrow as pa
import pyarrow.compute as pc

from aeb_sumo.errors import InputError
from aeb_sumo.results.schema import TABLES, Table

__all__ = ["Filters", "chosen", "expression", "names_of", "table_of"]

Filters = Sequence[tuple[str, str, Any]] | Sequence[Sequence[tuple[str, str, Any]]]

_OPERATORS: dict[str, Callable[[Any, Any], Any]] = {
    "==": lambda field, value: field == value,
    "!=": lambda field, value: field != value,
    "<": lambda field, value: field < value,
    "<=": lambda field, value: field <= value,
    ">": lambda field, value: field > value,
    ">=": lambda field, value: field >= value,
    "in": lambda field, value: field.isin(value),
    "not in": lambda field, value: ~field.isin(value),
}
_LISTS = ("in", "not in")
_KINDS = {"string": (str,), "int64": (int,), "float64": (int, float), "bool": (bool,)}


def table_of(name: str) -> Table:
    """A table by name.

    Raises:
        InputError: there is none.
    """
    if name not in TABLES:
        raise InputError(f"no table {name!r}; there are: {', '.join(TABLES)}")
    return TABLES[name]


def chosen(table: str, columns: Sequence[str] | None) -> list[str]:
    """Names of the columns that are asked for, None for all.

    Raises:
        InputError: the table has no such column.
    """
    there = [c.name for c in table_of(table).columns]
    if columns is None:
        return there
    if isinstance(columns, str):
        raise InputError(f"columns of {table} must be a list of names, not {columns!r}")
    for name in columns:
        if name not in there:
            raise InputError(f"table {table} has no column {name!r}; there are: {', '.join(there)}")
    return list(dict.fromkeys(columns))


def names_of(filters: Filters | None) -> list[str]:
    """Columns that filters look at."""
    return list(dict.fromkeys(one[0] for group in _groups(filters) for one in group))


def expression(table: str, filters: Filters | None) -> pc.Expression | None:
    """Filters as Arrow has them; None for all rows.

    Raises:
        InputError: something is not of the form above, a column does not exist, or a value is not of its type.
    """
    found = None
    for group in _groups(filters):
        every = None
        for one in group:
            term = _term(table, one)
            every = term if every is None else every & term
        found = every if found is None else found | every
    return found


def _groups(filters: Filters | None) -> list[list[Any]]:
    """Lists of conditions, of which one must hold."""
    if not filters:
        return []
    if isinstance(filters, str) or not isinstance(filters, Sequence):
        raise _wrong(filters)
    groups = [filters] if all(isinstance(one, tuple) for one in filters) else filters
    for group in groups:
        if not isinstance(group, list | tuple) or not group or not all(_is_condition(one) for one in group):
            raise _wrong(group)
    return [list(group) for group in groups]


def _is_condition(one: Any) -> bool:
    return isinstance(one, tuple) and len(one) == 3 and isinstance(one[0], str)


def _wrong(what: Any) -> InputError:
    return InputError(
        f"cannot read the filter {what!r}; write [(column, operator, value), ...], operator one of "
        f"{', '.join(_OPERATORS)}"
    )


def _term(table: str, condition: tuple[str, str, Any]) -> pc.Expression:
    name, operator, value = condition
    chosen(table, [name])
    if operator not in _OPERATORS:
        raise _wrong(condition)
    (dtype,) = (c.dtype for c in TABLES[table].columns if c.name == name)
    if operator in _LISTS and (isinstance(value, str) or not isinstance(value, list | tuple | set | frozenset)):
        raise InputError(f"filter {condition!r}: {operator!r} takes a list of values")
    values = [*value] if operator in _LISTS else [value]
    for each in values:
        plain = each.item() if hasattr(each, "item") else each
        if not isinstance(plain, _KINDS[dtype]) or (isinstance(plain, bool) and dtype != "bool"):
            raise InputError(f"filter {condition!r}: column {name} of {table} is of type {dtype}")
    field = pc.field(name)
    arrow = TABLES[table].arrow().field(name).type
    own = pa.array([v.item() if hasattr(v, "item") else v for v in values], arrow)
    return _OPERATORS[operator](field, own if operator in _LISTS else own[0]) & ~field.is_null(nan_is_null=True)
