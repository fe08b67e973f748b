"""Inputs that fuzzing found to be answered in a wrong way, small: each is refused since, by the reader of that name."""

import zipfile
from io import BytesIO


def _npz(header):
    """An archive of NumPy's, right but for an array's header."""
    file = BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("x.npy", b"\x93NUMPY\x01\x00v\x00" + header.ljust(117) + b"\n" + bytes(16))
    return file.getvalue()


START = b"{'descr': '<f8', 'fortran_order': False, "
HEADERS = tuple(
    _npz(START + end) for end in (b"'shape': (2,", b"'shape': (2L,), }", b"'': (2,), '")
)
TIMES = b"t,x,y\n" + b"".join(b"%d.5,0.0%d,0.06\n" % (k, 10 + k) for k in range(8))
LOG = b"t,q1,q2\n" + b"".join(b"%d,0.1,0.%d\n" % (k, k) for k in range(8))
SVG = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="20mm" height="%s" viewBox="0 0 9 9">'
    '<path d="M 2 2 C 1 1 2 %s 3 3" %s/></svg>'
)
SWEEP = b'{"what": "fivebar sweep", "variables": %s, "figures": %s, "robot": %s, "choices": {}, "designs": {}}'

ONCE = {
    "from_csv": (TIMES.replace(b"t,", b"t (s),").replace(b"\n1.5", b"\n5e-324"),),
    "path.csv": (b"x (mm);y (mm);pen\n90;60;1\n80;7e200;1\n",),
    "path.svg": tuple(
        (SVG % each).encode()
        for each in (("2e999mm", "2", ""), ("20mm", "2e999", ""), ("2e-310mm", "2", ""))
    ),
    "path.gcode": (b"G21 G90\nM3\nG0 X10 Y10\nG1 X2" + b"9" * 400 + b" Y10 F600\n",),
    "Map": HEADERS,
    "designs.npz": HEADERS,
    "chunk": HEADERS,
    "gradebook": (b"\nParticipant 1,A,20,\nParticipant 2,B,20\n3\n",),
    "certificate": (
        b'{"robot": {"l11": 0.09, "l12": 0.09, "l21": 0.09, "l22": 0.09, "d": 0.118}, "tolerances": {}, "working": '
        b'[-1, -1], "assembly": -1, "margin": 0.0, "pieces": [{"line": [[0.05, {}], [0.04, 0.09]]}], '
        b'"parts": [[0.0, 1.0]], "sha256": ""}',
    ),
    "calibrate": (b"q1,q2,x,y\n-2,-1,0.1,0.1\n-1,-2,0.1,-1e308\n",),
    "measured rows": (
        b"q1,q2,distance,to\n-2,-1,0.01,2\n-1,-2,0.01,1e276\n",
        b"q1,q2,x,y,assembly\n-2,-1,0,0,7\n",
    ),
    "Identification": (b"\xff", b'{"fivebar": "identification", "values": {}}'),
    "from_log": (
        LOG.replace(b"\n7,", b"\n1e308,"),
        LOG.replace(b"\n3,", b"\n1e30,"),
        LOG.replace(b"q2", b"q2,tau2"),
        LOG.replace(b"0.3\n", b"1e200\n"),
    ),
    "columns": (b"t,x\n1,2\n2,-1e308\n",),
    "Sweep.json": tuple(
        SWEEP % each
        for each in (
            (b"[true]", b"[]", b"{}"),
            (b"[]", b"[{}]", b"{}"),
            (b'["l1"]', b'[{"name": "bars"}]', b"5"),
        )
    ),
    "Design": (b'{"what": "fivebar designs", "choices": {}, "designs": []}',),
}
# Rows that are too short are filled; letters beyond ASCII are letters.
READ = {
    "path.svg": ((SVG % ("20mm", "2", 'f\u044d="1"')).encode(),),
    "gradebook": (
        b"Identifier,Full name,Maximum grade,Grade\nParticipant 1,A;20,\nParticipant 2,B,20,3\n",
        b"Identifier,Full name,Maximum grade,Grade\nPartici1,5",
        b"a,Grade\nA," + b"9" * 200_000 + b"\n",
    ),
}
