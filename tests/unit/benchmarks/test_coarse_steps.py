"""Every way to simulate samples is compared with the recipes' own."""

import coarse_steps


def test_a_row_for_each_way(capsys):
    assert coarse_steps.main(["--pushes", "1"]) == 0
    first, *rows = capsys.readouterr().out.splitlines()
    assert "CPU, share" in first
    assert [row[:22].strip() for row in rows] == list(coarse_steps.WAYS)
    for row in rows:
        cpu, *apart, both, before, now = row[22:].split()
        assert int(both) + int(before) + int(now) <= 12
        assert float(cpu) > 0.0
        if int(both) == 0:
            assert apart == ["nan", "nan"]
        else:
            assert all(float(word) > 0.0 for word in apart)
