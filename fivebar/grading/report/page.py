"""The report as HTML without scripts or network: a page of its own, or a fragment for a
notebook.
"""

from __future__ import annotations

from html import escape

from ...base.representation import printable
from ..judging.results import Report
from .text import closing, facts, headlines, not_started, number, shown_checks, total_words, word

POLICY = "default-src 'none'; style-src 'unsafe-inline'"
STYLE = """
.fivebar { font: 15px/1.5 system-ui, sans-serif; color: #1f2328; background: #fff; max-width: 62rem;
  margin: 0 auto; padding: 1rem; overflow-wrap: anywhere; box-sizing: border-box; }
.fivebar h1 { font-size: 1.35rem; margin: 0 0 .2rem; }
.fivebar h2 { font-size: 1.1rem; margin: 1.8rem 0 .5rem; }
.fivebar .total { font-size: 1.6rem; font-weight: 600; margin: .2rem 0 1rem; }
.fivebar .note { background: #fff8e0; border-left: 4px solid #d4a72c; padding: .5rem .8rem;
  margin: .6rem 0; }
.fivebar details { border-top: 1px solid #d8dee4; }
.fivebar summary { display: flex; gap: .8rem; padding: .45rem 0; cursor: pointer; }
.fivebar .flat { border-top: 1px solid #d8dee4; display: flex; gap: .8rem; padding: .45rem 0; }
.fivebar .word { flex: 0 0 4.2rem; text-align: center; border-radius: 1rem; color: #fff;
  font-size: .85rem;
  align-self: start; }
.fivebar .right { background: #1a7f37; }
.fivebar .partly { background: #8a6100; }
.fivebar .wrong { background: #c4320a; }
.fivebar .to { background: #57606a; }
.fivebar .broken { background: #6639ba; }
.fivebar .title { flex: 1; }
.fivebar small { color: #57606a; }
.fivebar .points { white-space: nowrap; font-variant-numeric: tabular-nums; }
.fivebar .body { display: flex; flex-wrap: wrap; gap: 1rem; padding: 0 0 .8rem; }
.fivebar dl { display: grid; grid-template-columns: 5rem 1fr; gap: .15rem .8rem; margin: 0;
  align-content: start;
  flex: 1 1 22rem; }
.fivebar dl dt { color: #57606a; float: none; width: auto; font-weight: inherit;
  }  /* in Jupyter lists float */
.fivebar dl dd { margin: 0; float: none; width: auto; }
.fivebar code, .fivebar pre { font: 13px/1.5 ui-monospace, monospace; }
.fivebar figure { margin: 0; flex: 0 1 300px; }
.fivebar figure svg { max-width: 100%; height: auto; background: #f6f8fa; border-radius: 6px; }
.fivebar figcaption { font-size: .85rem; color: #57606a; }
.fivebar pre { background: #f6f8fa; padding: .6rem; white-space: pre-wrap; }
.fivebar .hint { background: #eaf3ff; border-radius: 6px; padding: .1rem .5rem; }
@media print {  /* backgrounds are not printed, and what is folded would be lost */
  .fivebar .word { color: #000; border: 1px solid #000; }
  .fivebar details::details-content { content-visibility: visible; block-size: auto; }
}
"""
DARK = """
body { margin: 0; background: #fff; }
@media screen and (prefers-color-scheme: dark) {
  :root { color-scheme: dark; }
  body, .fivebar { color: #eceff2; background: #14171b; }
  .fivebar .note { background: #3a3013; }
  .fivebar details, .fivebar .flat { border-color: #4c555f; }
  .fivebar small, .fivebar dl dt, .fivebar figcaption { color: #a9b2bc; }
  .fivebar pre { background: #22272d; }
  .fivebar .hint { background: #1b2c44; }
  .fivebar figure svg { background: #e6e9ec; }
  .fivebar a { color: #8ab4f8; }
}
"""  # of whole pages: a notebook has its own theme
CODE = ("call", "returned", "where")
CAPTION = "Green: as it should be. Red, dashed: as your answer has it."


def text(value: str) -> str:
    """Return any text as HTML text, control characters made visible."""
    return escape(printable(value))


def page(title: str, body: str, style: str = "") -> str:
    """Return a whole page that may load nothing from anywhere."""
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<title>{text(title)}</title><style>{STYLE}{style}{DARK}</style></head>"
        f'<body><main class="fivebar">{body}</main></body></html>\n'
    )


def report_page(report: Report) -> str:
    return page(f"{report.lab}: {report.submission}", _body(report))


def fragment(report: Report) -> str:
    return f'<style>{STYLE}</style><div class="fivebar">{_body(report)}</div>'


def _body(report):
    notes = "".join(f'<p class="note">{text(note)}</p>' for note in headlines(report))
    checks = "".join(_check(check) for check in shown_checks(report))
    closings = "".join(f"<p>{text(note)}</p>" for note in closing(report))
    output = (
        f"<h2>Your program printed</h2><pre>{_lines(report.output)}</pre>"
        if report.output.strip()
        else ""
    )
    return (
        f"<h1>{text(report.lab)}: {text(report.submission)}</h1>"
        f'<p class="total">{total_words(report)}</p>'
        f"{notes}{checks}{closings}{output}"
    )


def _lines(output):
    return "\n".join(text(line) for line in output.splitlines()[:200])


def _check(check):
    task = (
        "".join(f"<br><small>{text(words)}</small>" for _, words in facts(check))
        if not_started(check)
        else ""
    )
    head = (
        f'<span class="word {word(check).split()[0]}">{word(check)}</span>'
        f'<span class="title">{text(check.title)}{task}</span>'
        f'<span class="points">{number(check.points)} / {number(check.max_points)}</span>'
    )
    if check.outcome == "right" or task:
        return f'<div class="flat">{head}</div>'
    items = "".join(_item(label, words) for label, words in facts(check))
    figure = (
        f"<figure>{check.figure}<figcaption>{CAPTION}</figcaption></figure>" if check.figure else ""
    )
    return (
        f"<details open><summary>{head}</summary><div"
        f' class="body"><dl>{items}</dl>{figure}</div></details>'
    )


def _item(label, words):
    words = f"<code>{text(words)}</code>" if label in CODE else text(words)
    return f"<dt>{label}</dt><dd{' class=hint' if label == 'hint' else ''}>{words}</dd>"
