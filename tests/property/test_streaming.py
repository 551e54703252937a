from tempfile import TemporaryDirectory

import pandas as pd
from hypothesis import given, settings
from hypothesis import strategies as st

from aeb_sumo.ledger.rows import Rows
from aeb_sumo.results import Results, read, writer

VALUES = st.floats(allow_nan=False) | st.none()


@settings(max_examples=30, deadline=None)
@given(
    values=st.lists(st.tuples(VALUES, st.text(max_size=3)), max_size=60),
    pack=st.integers(1, 20),
    group=st.integers(1, 50),
)
def test_streamed_rows_are_those_in_memory_whatever_the_size_of_batches(values, pack, group):
    rows = [{"conflict_id": k, "pet_s": pet, "ego": ego} for k, (pet, ego) in enumerate(values)]
    kept = Results.of({"conflicts": [{"run_id": "a"} | row for row in rows]})
    with TemporaryDirectory() as folder, writer.Writer(folder, "a", row_group=group) as one:
        book = Rows("conflicts", pack=pack)
        book.stream(lambda batch: one.put("conflicts", batch))
        for row in rows:
            book.append(row)
        assert len(book.of_run("a")) == 0, "nothing is kept"
        assert len(book) == len(rows)
        one.commit({"strategy": "none"})
        pd.testing.assert_frame_equal(read(folder).conflicts, kept.conflicts)
