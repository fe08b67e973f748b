"""The glossary's pictures, made by the package: `python -m tests.helpers.glossary_pictures` renews them."""

import io
from pathlib import Path

from PIL import Image

import fivebar as fb

FOLDER = Path(fb.__file__).parent / "guide"
WIDTH, WIDEST = 560, 760  # pixels: of a picture with two panels, and of any


def assembly(robot):
    poses = [fb.dgm(robot, (0.3, 0.6), assembly=mode) for mode in (-1, 1)]
    return poses, ["assembly mode −1 (default)", "assembly mode +1"]


def working(robot):
    poses = [fb.igm(robot, (0.0, 0.1), mode) for mode in ((-1, -1), (1, -1))]
    return poses, ["working modes −1, −1 (default)", "working modes +1, −1: elbows out"]


def types(robot):
    stretched = fb.igm(robot, (0.0065, 0.16765), (-1, -1))
    parallel = fb.check_path(robot, fb.line((0.09, 0.068), (0.05, 0.0), 4.0)).pose
    both = fb.dgm(robot, fb.singularity_loci(robot).type3.q[0] + 1e-9)
    titles = [
        "Type 1: left leg stretched",
        "Type 2: distal bars in line",
        "Type 3: left leg folded, too",
    ]
    return [stretched, parallel, both], titles


PICTURES = {"assembly": assembly, "working": working, "types": types}


def made(name):
    """The picture as PNG bytes: small, of few colours."""
    poses, titles = PICTURES[name](fb.FiveBar())
    file = io.BytesIO()
    fb.plot.pose(poses, titles).savefig(file, format="png", dpi=100)
    picture = Image.open(file).convert("RGB")
    width = min(WIDTH * len(poses) // 2, WIDEST)
    size = width, round(picture.height * width / picture.width)
    small = picture.resize(size, Image.Resampling.LANCZOS)
    method = Image.Quantize.MAXCOVERAGE
    palette = small.quantize(64, method=method, kmeans=2, dither=Image.Dither.NONE)
    out = io.BytesIO()
    palette.save(out, "PNG", optimize=True)
    return out.getvalue()


if __name__ == "__main__":
    for name in PICTURES:
        (FOLDER / f"glossary_{name}.png").write_bytes(made(name))
