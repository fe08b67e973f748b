"""README's pictures: `python -m tests.helpers.readme_pictures` renews all, or those whose names begin with its words.

contours and trackers are measurements: on a machine that does nothing else.
"""

import sys
import tempfile
from pathlib import Path

from PIL import Image

from fivebar.cli import main

from . import recording

FOLDER = Path(__file__).parents[2] / ".readme"
WIDEST = 1605  # pixels
ROWS = "t_s,x_m,y_m\n" + "".join(
    f"{k},{0.09 - 0.008 * k},{0.068 - 0.0136 * k}\n" for k in range(6)
)  # of the lab's task 2
# Name -> (the command, the file that it makes, pixels).
PICTURES = {
    "tracking": ("demo --out made", "made/tracking.png", WIDEST),
    "drawing": (
        "draw --example --fit --rate 500 --angles deg --out made",
        "made/drawing.png",
        1240,
    ),
    "map": ("map --path path.csv --out map.png", "map.png", 720),
    "contours": ("chart singularity-map --out made", "made/singularity-map.png", WIDEST),
    "trackers": ("chart trackers --out made", "made/trackers.png", WIDEST),
}


def renew(name, folder):
    """Makes .readme/NAME.png, of few colours."""
    command, made, width = PICTURES[name]
    words = [
        str(folder / word) if word == "made" or word.endswith((".csv", ".png")) else word
        for word in command.split()
    ]
    (folder / "path.csv").write_text(ROWS, encoding="utf-8")
    assert main(words) == 0
    picture = Image.open(folder / made).convert("RGB")
    picture = picture.resize(
        (width, round(picture.height * width / picture.width)), Image.Resampling.LANCZOS
    )
    method = Image.Quantize.MAXCOVERAGE  # in which thin lines keep their hues
    picture.quantize(256, method=method, dither=Image.Dither.NONE).save(
        FOLDER / f"{name}.png", "PNG", optimize=True
    )


if __name__ == "__main__":
    asked = tuple(sys.argv[1:])
    for name in [*PICTURES, "play"]:
        if not asked or name.startswith(asked):
            with tempfile.TemporaryDirectory() as folder:
                recording.main(FOLDER / "play.gif") if name == "play" else renew(name, Path(folder))
