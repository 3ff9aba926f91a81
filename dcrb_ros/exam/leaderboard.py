"""The leaderboard: entries sorted by their mark, as Markdown and HTML."""

from __future__ import annotations

import html
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path

from dcrb_ros.exam.agreement import Agreement, agreement
from dcrb_ros.exam.exam_score import ScoreDifference
from dcrb_ros.exam.leaderboard_entry import Entry, read_entry
from dcrb_ros.exam.marking import Marking, compare, marking_of
from dcrb_ros.exam.statistics import CONFIDENCE
from dcrb_ros.schema.printable import printable
from dcrb_ros.schema.refusal import Refusal, repeated
from dcrb_ros.text.files import checked_path
from dcrb_ros.text.markdown import table

MEASURED_HEAD = "correct on measured recordings"
"""Head of the last column of a leaderboard that is compared with measured recordings."""


@dataclass(frozen=True)
class Board:
    """The entries of one exam, the best one first."""

    exam: str
    scenarios_sha256: str
    entries: tuple[Entry, ...]
    comparisons: tuple[ScoreDifference, ...]
    """Comparison of each entry with the next one."""
    field: Agreement | None = None
    """Comparison with measured recordings, if there is one."""

    @property
    def marking(self) -> Marking:
        """How they are marked."""
        return marking_of(self.entries[0])

    @property
    def heads(self) -> tuple[str, ...]:
        """Heads of the columns."""
        return ("", "detector", *self.marking.heads(self.entries), "better than the next", *([MEASURED_HEAD] if self.field else []))


def read_boards(folder: Path, measured: Path | None = None) -> list[Board]:
    """Return the leaderboards of a folder of entries, one for each set of scenarios and criteria.

    With a folder of entries on measured recordings, each is compared with them.

    Raises:
        Refusal: there is no such folder, it has no entry, one of them is invalid, or there are too few detectors to compare.
    """
    found = boards(read_entries(folder))
    if measured is None:
        return found
    on_recordings = read_entries(measured)
    return [replace(board, field=agreement(board.entries, on_recordings)) for board in found]


def read_entries(folder: Path) -> list[Entry]:
    """Return the entries of a folder, in the order of their files.

    Raises:
        Refusal: there is no such folder, it has no entry, or one of them is invalid.
    """
    if not checked_path(folder).is_dir():
        raise Refusal(f"there is no folder {folder}: give a folder with entries of dcrb score --entry")
    files = sorted(file for file in folder.glob("*.json") if not file.name.startswith("."))
    if not files:
        raise Refusal(f"{folder} has no .json file: make entries with dcrb score EXAM --entry {folder}/NAME.json")
    return [read_entry(file) for file in files]


def boards(entries: Sequence[Entry]) -> list[Board]:
    """Return the leaderboards of entries, one for each set of scenarios and criteria; entries without an exam score are refused.

    Raises:
        Refusal: an entry has no exam score, or two entries of one exam have the same name.
    """
    groups: dict[tuple[str, str, bool, str], list[Entry]] = {}
    for entry in entries:
        if not entry.exam_score:
            raise Refusal(f"the entry '{entry.detector}' of the exam {entry.exam} has no exam score: it takes faults and healthy time")
        # One exam may have several titles, such as a replica of the same table in folders of two names.
        title = "" if entry.scenarios_sha256 else entry.exam
        groups.setdefault((title, entry.scenarios_sha256, entry.last_verdict, entry.criteria_sha256), []).append(entry)
    ordered = sorted(groups.items(), key=lambda item: (item[1][0].exam, *item[0][1:]))
    return [_board(group) for _, group in ordered]


def _board(entries: Sequence[Entry]) -> Board:
    if (twice := repeated(entry.detector for entry in entries)) is not None:
        raise Refusal(f"two entries of the exam {entries[0].exam} are called '{twice}': give them different names with --name")
    marking = marking_of(entries[0])
    ordered = sorted(entries, key=lambda entry: (-marking.mark(entry), entry.detector))
    return Board(entries[0].exam, entries[0].scenarios_sha256, tuple(ordered), tuple(compare(marking, *pair) for pair in pairwise(ordered)))


def rows(board: Board) -> Iterator[tuple[str, ...]]:
    """Yield the cells of each row; see `Board.heads`."""
    shares = dict(zip(board.field.detectors, board.field.measured, strict=True)) if board.field else {}
    heads = board.marking.heads(board.entries)
    better = [f"{'yes' if each.distinguished else 'not shown'}, {each.confidence:.1%}" for each in board.comparisons]
    for number, (entry, than_next) in enumerate(zip(board.entries, [*better, "–"], strict=True), 1):
        share = [f"{shares[entry.detector]:.0f}%" if entry.detector in shares else "–"] if board.field else []
        yield str(number), printable(entry.detector), *board.marking.cells(entry, heads), than_next, *share


def about(board: Board) -> str:
    """Return what a board shows, in one paragraph."""
    versions = ", ".join(sorted({f"dcrb_ros {entry.dcrb_ros}, model {entry.model}" for entry in board.entries}))
    seals = {entry.sealed_sha256 for entry in board.entries} - {""}
    sealed = f"; sealed as {', '.join(sorted(seals))}" if seals else ""
    criteria = max(entry.criteria_sha256 for entry in board.entries)[:8]
    return (
        f"{len(board.entries[0].scenarios)} scenarios, sha256 {board.scenarios_sha256 or '(recordings)'}"
        f"{f', criteria {criteria}' if criteria else ''}{sealed}; {versions}. "
        f"{board.marking.about}. The column 'better than the next' says whether the {CONFIDENCE:.0%} interval of the difference from the "
        "next detector on the same scenarios excludes 0, and in which share of the bootstrap samples the detector is better."
        f"{_agreement(board.field)}"
    )


def _agreement(field: Agreement | None) -> str:
    """Return how well the order of a board agrees with that on measured recordings, as a sentence after others."""
    if field is None:
        return ""
    tau, rho = (f"{value.value:.2f} ({value.low:.2f} to {value.high:.2f})" for value in (field.kendall, field.spearman))
    return (
        f" The order of {len(field.detectors)} detectors agrees with that of their shares of correct verdicts on measured recordings with "
        f"Kendall's tau-b {tau} and Spearman's rho {rho}."
    )


def markdown(boards: Sequence[Board], figures: Sequence[str]) -> str:
    """Return leaderboards as Markdown; ``figures`` names the picture of each."""
    lines = ["# Leaderboard", "", "Written by `dcrb exam table`.", ""]
    for board, figure in zip(boards, figures, strict=True):
        lines += [f"## {_plain(board.exam)}", "", about(board), "", f"![{board.marking.caption} of {_plain(board.exam)}]({figure})", ""]
        lines += [table(board.heads, (tuple(map(_plain, row)) for row in rows(board))), ""]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Return a user's text without characters that Markdown or HTML read as markup."""
    return html.escape(text, quote=False).translate({ord(character): f"\\{character}" for character in "|`*_[]\\"})


def page(boards: Sequence[Board], figures: Sequence[str]) -> str:
    """Return leaderboards as a page of HTML."""
    parts = []
    for board, figure in zip(boards, figures, strict=True):
        head = "".join(f"<th>{html.escape(cell)}</th>" for cell in board.heads)
        body = "\n".join("<tr>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in row) + "</tr>" for row in rows(board))
        name = html.escape(board.exam)
        picture = f'<img src="{html.escape(figure)}" alt="{board.marking.caption} of {name}">'
        parts.append(f"<h2>{name}</h2>\n<p>{html.escape(about(board))}</p>\n{picture}\n<table>\n<tr>{head}</tr>\n{body}\n</table>")
    return f"{PAGE_HEAD}\n<body>\n<h1>Exam of fault detectors</h1>\n{chr(10).join(parts)}\n</body>\n</html>\n"


PAGE_HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>Exam of fault detectors</title>
<style>
body { font-family: sans-serif; max-width: 75em; margin: 2em auto; padding: 0 1em; }
img { max-width: 100%; }
table { border-collapse: collapse; }
th, td { border-bottom: 1px solid #ccc; padding: 0.3em 0.7em; text-align: left; }
</style>
</head>"""
"""Head of the HTML page."""
