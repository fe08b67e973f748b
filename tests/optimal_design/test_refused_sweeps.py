"""Designs as people have them, and what is said of sweeps that cannot be."""

import numpy as np
import pytest

import fivebar as fb

from .test_sweep import swept


def test_folders_that_cannot_be_used(tmp_path):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.tex").write_text("precious", encoding="utf-8")
    with pytest.raises(
        ValueError, match=r"mine holds thesis.tex and no manifest.json: give another"
    ):
        swept(tmp_path / "mine")
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.tex"]
    (tmp_path / "file").write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="file is a file, not a folder"):
        swept(tmp_path / "file")
    with pytest.raises(ValueError, match="out: 'a.x00b': "):  # fuzzing found it
        swept("a\0b")
    with pytest.raises(ValueError, match="path: "):
        swept(None, path="\ud800")
    with pytest.raises(OSError, match="/proc/sweep"):
        swept("/proc/sweep")
    out = tmp_path / "out"
    swept(out)
    chunk = out / "chunk-000003.npz"
    kept = chunk.read_bytes()
    chunk.write_bytes(kept[:200])
    with pytest.raises(
        ValueError, match="chunk-000003.npz is no chunk of a sweep, or not whole .* delete it"
    ):
        swept(out)
    chunk.unlink()
    swept(out)
    assert chunk.read_bytes() == kept
    (out / "manifest.json").write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match="manifest.json is not what a sweep left there"):
        swept(out)
    with pytest.raises(ValueError, match="holds no sweep"):
        fb.optimal_design.Sweep.load(tmp_path)


@pytest.mark.parametrize(
    "asked, error, notes",
    [
        (
            lambda: fb.sweep("speed", {"l1": [0.1]}),
            ValueError,
            "figure: no figure 'speed'; the known ones are workspace",
        ),
        (lambda: fb.sweep([], {"l1": [0.1]}), ValueError, "figure: none is asked for"),
        (
            lambda: fb.sweep(5, {"l1": [0.1]}),
            TypeError,
            "figure must be a name, a function of a robot or a list",
        ),
        (lambda: fb.sweep(["bars", "bars"], {"l1": [0.1]}), ValueError, "bars is asked for twice"),
        (
            lambda: fb.sweep([lambda robot: robot.l11, lambda robot: robot.l12], {"l1": [0.1]}),
            ValueError,
            "figure: <lambda> is asked for twice; .* as {name: function}",
        ),
        (
            lambda: fb.sweep("det_A", {"l1": [0.1]}),
            ValueError,
            "det_A needs table=... or disc=radius",
        ),
        (
            lambda: fb.sweep("tip_speed", {"l1": [0.1]}, table=(1, 1)),
            ValueError,
            "tip_speed needs motor=",
        ),
        (
            lambda: fb.sweep("bars", {"l9": [0.1]}),
            ValueError,
            "designs: no parameter 'l9' of a design; the known",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1], "l11": [0.1]}),
            ValueError,
            "designs: l11 and l1 both set l11",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1, 0.2], "l2": [1, 2, 3]}),
            ValueError,
            "columns of unlike lengths",
        ),
        (
            lambda: fb.sweep("bars", {"l1": "long"}),
            ValueError,
            r"designs\[l1\] must be real numbers",
        ),
        (lambda: fb.sweep("bars", {}), ValueError, "designs: no column is given"),
        (lambda: fb.sweep("bars", []), ValueError, "designs: there is none"),
        (
            lambda: fb.sweep("bars", [5]),
            TypeError,
            "designs must be robots as FiveBar, or tables by name, not 5",
        ),
        (
            lambda: fb.sweep("bars", [{"l1": 0.1}, {"l2": 0.1}]),
            ValueError,
            r"designs\[1\] must name l1, as the first",
        ),
        (
            lambda: fb.sweep("bars", "designs.xlsx"),
            ValueError,
            "a .csv or .npz file, not 'designs.xlsx'",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, tabel=(1, 1)),
            TypeError,
            "no choice tabel; the known ones are table",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, table=(1, 1), disc=1),
            ValueError,
            "a table or a disc, not both",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, table=(1, 0, 0, 1)),
            ValueError,
            "x_min, x_max, .* must rise",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, table=(-1, 1)),
            ValueError,
            "table must be finite and > 0",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, motor="maxon"),
            ValueError,
            "no motor 'maxon'; the known ones are ax-12a, xh430",
        ),
        (lambda: fb.sweep("bars", {"l1": [0.1]}, motion=5), TypeError, "motion must be a function"),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, tolerances={"x": 1}),
            ValueError,
            "tolerances must be a table of",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, robot=5),
            TypeError,
            "robot must be a robot, as FiveBar",
        ),
        (
            lambda: fb.sweep("bars", {"l1": [0.1]}, chunk=0),
            ValueError,
            "chunk must be a whole number >= 1",
        ),
        (
            lambda: fb.optimal_design.sample({"l1": (0.2, 0.1)}, 5),
            ValueError,
            r"l1 = \(0.2, 0.1\) is the wrong way round",
        ),
        (lambda: fb.optimal_design.grid({}), TypeError, "axes must be a table"),
    ],
)
def test_what_is_refused(asked, error, notes):
    with pytest.raises(error, match=notes):
        asked()


def test_a_file_of_designs_that_is_wrong_says_where(tmp_path):
    file = tmp_path / "designs.csv"
    file.write_text("l1,d\n0.1,0.1\n0.1,long\n", encoding="utf-8")
    with pytest.raises(ValueError, match="designs.csv, line 3: .*long"):
        fb.sweep("bars", file)
    file.write_text("l1,d\n0.1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="designs.csv, line 2: "):
        fb.sweep("bars", file)
    file.write_text("l1,d\n0.1,0.1\n0.1,70 mm\n", encoding="utf-8")
    with pytest.raises(ValueError, match=r"line 3: .*; its unit goes into the heading: d \(mm\)"):
        fb.sweep("bars", file)
    file.write_text("l1,d\n0.1,0.1\n100,0.1\n", encoding="utf-8")
    with pytest.raises(ValueError, match="line 3: l1: 100 m: did you mean 100 mm. Write the unit"):
        fb.sweep("bars", file)
    np.savez(tmp_path / "designs.npz", l1=[0.1, 0.2], d=[0.1])
    with pytest.raises(ValueError, match="designs.npz: .*d"):
        fb.sweep("bars", tmp_path / "designs.npz")
    file.write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match="designs.csv"):
        fb.sweep("bars", file)
    file.write_text("l1,lenght2\n0.1,3\n", encoding="utf-8")
    with pytest.raises(
        ValueError,
        match="designs.csv: column 'lenght2' is not used; the parameters of a design are l1, l2",
    ):
        fb.sweep("bars", file)


def test_files_of_designs_as_people_have_them(tmp_path):
    file = tmp_path / "designs.csv"
    file.write_text(
        "sep=;\nl1 (mm);l2_mm;d (cm);m (g);bars\n100;120,5;5;300;7\n90;130;4;250;8\n",
        encoding="utf-16",
    )
    done = fb.sweep("bars", file)
    assert done.names == ("l1", "l2", "d", "m") and done.design(0) == pytest.approx(
        {"l1": 0.1, "l2": 0.1205, "d": 0.05, "m": 0.3}
    )
    done.to_csv(tmp_path / "again.csv")  # a sweep's own table
    again = fb.sweep("bars", tmp_path / "again.csv")
    np.testing.assert_array_equal(again["bars"], done["bars"])
    assert done.best("bars").tolist() == [1] and done.best("bars", sense="max").tolist() == [0]
    with pytest.raises(ValueError, match="sense must be one of min, max"):
        done.best(sense="least")
