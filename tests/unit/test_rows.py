import pyarrow as pa

from aeb_sumo.ledger.rows import Rows
from aeb_sumo.results import TABLES, Results


def rows(count):
    book = Rows("conflicts")
    for k in range(count):
        book.append(
            {"conflict_id": k, "kind": "crossing", "ego": f"car.{k}", "min_ttc_s": k / 7, "near_crash": k % 2 == 0}
        )
    return book


def test_packed_rows_are_the_rows_that_were_added():
    book = rows(1300)
    assert len(book) == 1300
    table = book.of_run("a")
    assert table.schema.equals(TABLES["conflicts"].arrow(), check_metadata=True)
    frame = Results.of({"conflicts": table}).conflicts
    assert set(frame["run_id"]) == {"a"}
    assert frame["conflict_id"].tolist() == list(range(1300))
    assert frame["min_ttc_s"].tolist() == [k / 7 for k in range(1300)]
    assert frame["pet_s"].isna().all()


def test_a_table_without_rows_has_its_columns():
    table = Rows("interventions").of_run("a")
    assert table.num_rows == 0
    assert table.schema.equals(TABLES["interventions"].arrow(), check_metadata=True)


def test_a_row_costs_few_bytes():
    before = pa.total_allocated_bytes()
    book = rows(5120)
    assert (pa.total_allocated_bytes() - before) / len(book) < 300
