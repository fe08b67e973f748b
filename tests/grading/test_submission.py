"""Files handed in: what is read, and what is refused with a sentence."""

import json
import os
import zipfile

import pytest

from fivebar.grading.worker.student import Student
from fivebar.grading.worker.submission import (
    MOST_NOTEBOOK,
    MOST_SOURCE,
    Submission,
    SubmissionError,
    read_submission,
)


def notebook(*cells):
    return json.dumps(
        {"nbformat": 4, "cells": [{"cell_type": kind, "source": source} for kind, source in cells]}
    )


def test_a_python_file_is_read_as_python_reads_it(tmp_path):
    file = tmp_path / "five_bar_models.py"
    for data in (
        "# é\r\nl = 1\r\n".encode(),
        b"\xef\xbb\xbf# \xc3\xa9\nl = 1\n",
        b"#\xe9\rl = 1\r",
    ):
        if data.startswith(b"#\xe9"):
            data = b"# -*- coding: latin-1 -*- \xe9\n" + data
        file.write_bytes(data)
        found = read_submission(file)
        assert (found.name, found.kind, found.cells) == ("five_bar_models.py", "py", ())
        assert "é" in found.source and found.source.endswith("l = 1\n") and "\r" not in found.source
    assert found.where(12) == "line 12"


def test_a_notebooks_lines_are_pythons_lines(tmp_path):
    file = tmp_path / "lab.ipynb"
    file.write_text(
        notebook(("code", 'a = "\u2028\x0c"\r\nb = 1'), ("code", ["c = 2\n", "d = 3\n"])),
        encoding="utf-8",
    )
    assert read_submission(file).source == 'a = "\u2028\x0c"\nb = 1\nc = 2\nd = 3\n'
    assert read_submission(file).where(4) == "code cell 2, line 2"


def test_a_notebooks_code_is_read_without_its_magics(tmp_path):
    file = tmp_path / "lab.ipynb"
    file.write_text(
        notebook(
            ("markdown", "def no(): pass"),
            ("code", ["%matplotlib inline\n", "!pip install x\n", "import math\n", "?help"]),
            ("code", "%%bash\nrm -r *"),
            ("code", ""),
            ("code", "%%time\ndef f(x):\n    return math.cos(x)"),
            ("raw", "1/0"),
        ),
        encoding="utf-8",
    )
    found = read_submission(str(file))
    assert found.kind == "notebook" and found.cells == (1, 5, 7, 7)
    assert found.source == "\n\nimport math\n\n\n\n\ndef f(x):\n    return math.cos(x)\n"
    assert found.where(9) == "code cell 4, line 3" and found.where(3) == "code cell 1, line 3"
    with Student(found) as student:
        assert student.trouble is None and student.ask("f", [(0.0,)])[0].value == 1.0


REFUSED = {
    "symbolic link": "a.py is a symbolic link",
    "link to nothing": "a.py is a symbolic link",
    "folder": "a.py is not a regular file",
    "pipe": "a.py is not a regular file",
    "missing": "a.py cannot be opened: No such file",
    "too large": "a.py is larger than 1 MB",
    "not what it states": r"a.py is not ASCII text \(byte 0xe9 in line 2\): save it as UTF-8",
    "half of UTF-16": "a.py is not UTF-16 text",
    "member of no zip": "a.zip is no zip that can be read",
    "no such member": "b.zip holds no a.py",
    "costly encoding": "states the encoding 'punycode': save it as UTF-8",
    "unknown encoding": "states the encoding 'klingon'",
    "not a notebook": "a.ipynb is not a notebook of version 4",
    "deep notebook": "a.ipynb is not a notebook",
    "strange notebook": "a.ipynb is not a notebook",
    "old notebook": "a.ipynb is not a notebook",
    "enormous notebook": "a.ipynb is larger than 20 MB",
    "long notebook": "a.ipynb holds more than 1000000 characters",
    "newline in the name": r"the file's name 'a\\nb.py' is too long or holds characters that cannot be shown",
    "codes in the name": r"the file's name '\\x1b\[2J.py'",
    "undecodable name": "the file's name",
    "long name": "the file's name",
    "other kind": "a.txt is neither a .py file nor an .ipynb notebook",
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_a_submission_is_refused(case, tmp_path):
    file = tmp_path / "a.py"
    book = tmp_path / "a.ipynb"
    (tmp_path / "real.py").write_text("l = 1", encoding="utf-8")
    path = {
        "symbolic link": lambda: file.symlink_to(tmp_path / "real.py") or file,
        "link to nothing": lambda: file.symlink_to("nothing") or file,
        "folder": lambda: file.mkdir() or file,
        "pipe": lambda: os.mkfifo(file) or file,
        "missing": lambda: file,
        "too large": lambda: file.write_bytes(b"#" * (MOST_SOURCE + 1)) and file,
        "not what it states": lambda: file.write_bytes(b"# coding: ascii\n# \xe9\n") and file,
        "half of UTF-16": lambda: file.write_bytes("l = 1".encode("utf-16")[:-1]) and file,
        "member of no zip": lambda: (
            (tmp_path / "a.zip").write_text("PK", encoding="utf-8") and tmp_path / "a.zip"
        ),
        "no such member": lambda: (
            zipfile.ZipFile(tmp_path / "b.zip", "w").close() or tmp_path / "b.zip"
        ),
        "costly encoding": lambda: file.write_bytes(b"#!python\n# coding: punycode\n") and file,
        "unknown encoding": lambda: (
            file.write_bytes(b"# vim: set fileencoding=klingon :\n") and file
        ),
        "not a notebook": lambda: book.write_text("l = 1", encoding="utf-8") and book,
        "deep notebook": lambda: book.write_text("[" * 200_000, encoding="utf-8") and book,
        "strange notebook": lambda: (
            book.write_text(
                '{"cells": [{"cell_type": "code", "source": [1, null]}]}', encoding="utf-8"
            )
            and book
        ),
        "old notebook": lambda: (
            book.write_text('{"nbformat": 3, "worksheets": []}', encoding="utf-8") and book
        ),
        "enormous notebook": lambda: book.write_bytes(b" " * (MOST_NOTEBOOK + 1)) and book,
        "long notebook": lambda: (
            book.write_text(notebook(("code", "#" * MOST_SOURCE)), encoding="utf-8") and book
        ),
        "newline in the name": lambda: tmp_path / "a\nb.py",
        "codes in the name": lambda: tmp_path / "\x1b[2J.py",
        "undecodable name": lambda: tmp_path / os.fsdecode(b"\xff.py"),
        "long name": lambda: tmp_path / ("a" * 210 + ".py"),
        "other kind": lambda: tmp_path / "a.txt",
    }[case]()
    with pytest.raises(SubmissionError, match=REFUSED[case]) as refusal:
        read_submission(path, "a.py" if path.suffix == ".zip" else "")
    assert str(refusal.value).isprintable() and len(str(refusal.value)) < 400


def test_a_hostile_name_that_can_be_shown_is_kept_as_it_is(tmp_path):
    """It is the reports' part to write it safely; a path is never made of it."""
    for name in ("=cmd().py", "<script>.py", "..py", "-rf.py", "a'; DROP.py"):
        (tmp_path / name).write_text("def f(): return 1", encoding="utf-8")
        found = read_submission(tmp_path / name)
        assert found == Submission(name, "def f(): return 1")
