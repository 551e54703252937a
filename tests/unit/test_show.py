"""Tables on the terminal."""

import pandas as pd
import pytest

from aeb_sumo.cli.show import print_frame, print_summary

NAMES = [f"staged, scenario highway, parameters brake_ttc={k / 10}" for k in range(1, 13)]


def of_many_groups() -> pd.DataFrame:
    figures = pd.MultiIndex.from_tuples([("traffic", "runs", ""), ("crashes", "crash rate", "1/10⁶ km")])
    return pd.DataFrame({name: [k, 1.5] for k, name in enumerate(NAMES)}, index=figures)


@pytest.mark.parametrize(
    "show", [lambda: print_summary(of_many_groups(), "campaign"), lambda: print_frame(of_many_groups().T, "campaign")]
)
def test_no_name_of_a_group_is_cut_off_however_many_there_are(capsys, show):
    show()
    out = capsys.readouterr().out
    assert "…" not in out
    assert max(map(len, out.splitlines())) <= 110
    assert [out.count(name.split()[-1]) for name in NAMES] == [1] * 12
