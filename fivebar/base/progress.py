"""Progress bars: on a terminal only; a pipe or a log gets none."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from tqdm import tqdm


def progress(iterable: Iterable | None = None, **options: Any) -> tqdm:
    """Return tqdm(iterable, **options), which writes nothing where stderr is no terminal."""
    return tqdm(iterable, disable=None, dynamic_ncols=True, **options)
