"""Every way to simulate samples is compared with the recipes' own."""

import coarse_steps


def test_a_row_for_each_way(capsys):
    assert coarse_steps.main(["--pushes", "1"]) == 0
    first, *rows = capsys.readouterr().out.splitlines()
    assert "CPU, share" in first
    assert [row[:22].strip() for row in rows] == list(coarse_steps.WAYS)
    for row in rows:
        assert sum(int(count) for count in row.split()[-3:]) <= 12
        assert all(float(word) > 0 for word in row[22:].split()[:3])
