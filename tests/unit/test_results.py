import pandas as pd
import pyarrow.parquet as pq
import pytest

from aeb_sumo.errors import InputError
from aeb_sumo.results import TABLES, Results, holds_results, read, write


def one_run(run_id="a", **tables):
    return Results.of({"runs": [{"run_id": run_id, "strategy": "none"}], **tables})


def test_tables_without_rows_keep_their_columns(tmp_path):
    write(one_run(), tmp_path)
    for name, table in TABLES.items():
        frame = pd.read_parquet(tmp_path / name)
        assert list(frame.columns) == [c.name for c in table.columns]
    assert len(pd.read_parquet(tmp_path / "crashes")) == 0


def test_units_and_meanings_travel_with_the_file(tmp_path):
    write(one_run(), tmp_path)
    field = read(tmp_path).tables["crashes"].schema.field("impact_speed_mps")
    assert field.metadata[b"unit"] == b"m/s"


def test_runs_side_by_side(tmp_path):
    write(one_run("a"), tmp_path)
    write(one_run("b"), tmp_path)
    assert read(tmp_path).runs["run_id"].tolist() == ["a", "b"]


def test_no_half_files(tmp_path):
    write(one_run(), tmp_path)
    assert not list(tmp_path.rglob("*.partial"))


def test_reading_what_is_no_results(tmp_path):
    assert not holds_results(tmp_path)
    with pytest.raises(InputError, match="no results"):
        read(tmp_path)
    write(one_run(), tmp_path)
    (tmp_path / "crashes" / "a.parquet").write_text("no parquet")
    with pytest.raises(InputError, match="cannot read"):
        read(tmp_path)
    pd.DataFrame({"x": [1]}).to_parquet(tmp_path / "crashes" / "a.parquet")
    with pytest.raises(InputError, match="another schema"):
        read(tmp_path)


def test_results_of_another_version_are_refused_though_their_columns_are_the_same(tmp_path):
    write(one_run(), tmp_path)
    path = tmp_path / "crashes" / "a.parquet"
    table = pq.read_table(path)
    pq.write_table(table.replace_schema_metadata(table.schema.metadata | {b"schema_version": b"3"}), path)
    with pytest.raises(InputError, match="version 3 instead of"):
        read(tmp_path)


def test_every_column_is_documented():
    for table in TABLES.values():
        assert table.meaning.endswith(".")
        for column in table.columns:
            assert column.meaning
            assert column.unit
            if column.dtype == "float64" and column.unit != "-":
                suffix = {"1/h": "vph", "m/s": "mps", "m/s2": "mps2", "deg": "deg"}.get(column.unit, column.unit)
                assert column.name.endswith(f"_{suffix}"), column.name
