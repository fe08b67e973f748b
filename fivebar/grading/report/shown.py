"""The report as a session shows it."""

from __future__ import annotations

from dataclasses import dataclass

from ..judging.results import Report
from .page import fragment
from .text import report_text


@dataclass(frozen=True, repr=False)
class ShownReport(Report):
    """A Report that is text in a terminal, and in a notebook a page's fragment."""

    def __repr__(self) -> str:
        return report_text(self)

    def _repr_html_(self) -> str:
        return fragment(self)
