"""`dcrb exam`: seal, open and verify exams; make the leaderboard, and compare it with measured recordings."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from dcrb_ros.cli.commands import Commands
from dcrb_ros.cli.exam_predictivity import predictivity, replica
from dcrb_ros.cli.options import Force
from dcrb_ros.cli.output_file import check_file, check_output
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.counts import counted
from dcrb_ros.text.writing import whole_files, whole_folder, write_whole

if TYPE_CHECKING:
    from dcrb_ros.exam.exam_file import Exam

app = Commands(help="Seal and open exams drawn from a secret seed; verify entries; make a leaderboard; compare with measured recordings.")
Sealed = Annotated[Path, typer.Argument(help="The sealed exam, which has been published.")]
Secret = Annotated[Path, typer.Argument(help="The file with the secret seed.")]


@app.command()
def seal(
    template: Annotated[Path, typer.Argument(help="An exam file whose scenarios have 'draw' and 'count'.")],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="File to publish. Default: the template's name and .sealed.yaml.")
    ] = None,
    secret: Annotated[Path | None, typer.Option(help="File for the secret seed. Default: the template's name and .secret.")] = None,
    force: Force = False,
) -> None:
    """Draw an exam from a new secret seed, and write the file to publish before the exam and the secret to keep until after it.

    Example: dcrb exam seal my_template.yaml
    """
    from dcrb_ros.exam.sealing import new_secret
    from dcrb_ros.exam.sealing import seal as sealed_exam
    from dcrb_ros.text.files import checked_path
    from dcrb_ros.text.yaml import read_yaml, yaml_text

    published, kept = output or template.with_suffix(".sealed.yaml"), secret or template.with_suffix(".secret")
    if published.resolve() in (kept.resolve(), template.resolve()) or kept.resolve() == template.resolve():
        raise Refusal(f"{template}, {published} and {kept} must be three files: give --output and --secret other names")
    check_file("--output", published, force=force)
    check_file("--secret", kept, force=force)
    seed = new_secret()
    sealed = sealed_exam(read_yaml(checked_path(template)), seed, str(template))
    with whole_files(published, kept) as (public, private):
        public.write_bytes(yaml_text(sealed.model_dump()).encode())
        private.chmod(0o600)
        private.write_text(f"{seed}\n", encoding="utf-8")
    print(f"publish {published}, whose hash is {sealed.sealed}")
    print(f"keep {kept} secret until the exam is over")


@app.command("open")
def open_(
    sealed: Sealed,
    secret: Secret,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="Exam file. Default: the sealed file's name and .opened.yaml.")
    ] = None,
    force: Force = False,
) -> None:
    """Check that the secret seed is the one with which an exam was sealed, and write the exam for dcrb score.

    Example: dcrb exam open my_template.sealed.yaml my_template.secret
    """
    from dcrb_ros.exam.sealing import open_exam, read_sealed, read_secret
    from dcrb_ros.text.yaml import yaml_text

    file = output or sealed.with_name(f"{sealed.name.removesuffix('.yaml').removesuffix('.sealed')}.opened.yaml")
    check_file("--output", file, force=force)
    exam, tree = open_exam(read_sealed(sealed), read_secret(secret), str(sealed))
    write_whole(file, yaml_text(tree))
    print(f"{file}: {counted(len(exam.cases), 'scenario')}; score it with dcrb score {shlex.quote(str(file))}")


@app.command()
def verify(
    exam: Annotated[Path, typer.Argument(help="The sealed exam, which has been published, or an exam that is not sealed.")],
    files: Annotated[
        list[Path],
        typer.Argument(metavar="SECRET|ENTRY", help="The file with the secret seed of a sealed exam; entries of dcrb score --entry."),
    ],
) -> None:
    """Verify entries that were made with an exam, and a sealed one by its secret; exit status 1 if any does not agree or is unreadable.

    Example: dcrb exam verify my_template.sealed.yaml my_template.secret results/*.json
    """
    from dcrb_ros.exam.exam_file import LARGEST_EXAM, exam_of
    from dcrb_ros.settings.shipped import find_shipped
    from dcrb_ros.text.yaml import read_yaml

    tree = read_yaml(find_shipped("exam", exam), LARGEST_EXAM)
    if isinstance(tree, Mapping) and "sealed" in tree:
        secret, *entries = files
        drawn, agree = _verified(exam, secret)
    else:
        entries, drawn, agree = files, exam_of(tree, str(exam)), True
    for path in entries:
        agree = _verify_entry(path, drawn) and agree
    if not agree:
        raise typer.Exit(1)


def _verified(sealed: Path, secret: Path) -> tuple[Exam, bool]:
    """Verify a sealed exam; return the exam that is drawn from it, and whether its scenarios are those that were sealed."""
    from dcrb_ros.exam.sealing import commitment, open_exam, read_sealed, read_secret

    exam, seed = read_sealed(sealed), read_secret(secret)
    if commitment(exam.template, seed) != exam.sealed:
        print(
            f"{sealed}: DOES NOT AGREE, it was not sealed with this secret or has been changed since: "
            "give the file as it was published, and the secret that was sealed with it"
        )
        raise typer.Exit(1)
    print(f"{sealed}: agrees with the secret")
    drawn, _ = open_exam(exam, seed, str(sealed))
    agree = drawn.digest == exam.scenarios_sha256
    print(f"scenarios: {'agree' if agree else f'DO NOT AGREE, {_other_scenarios(exam.dcrb_ros)}'}")
    return drawn, agree


def _other_scenarios(version: str) -> str:
    """Return why the scenarios drawn from a sealed exam of a ``version`` of dcrb_ros are not those whose hash it states."""
    from dcrb_ros.runtime.version import __version__

    if version == __version__:
        return "scenarios_sha256 has been changed, or this dcrb_ros has other defaults: give the file as it was published"
    return f"the scenarios of dcrb_ros {__version__} are not those of dcrb_ros {version}, which sealed it: verify it with that version"


def _verify_entry(path: Path, exam: Exam) -> bool:
    """Print and return whether an entry agrees with an exam."""
    from dcrb_ros.exam.leaderboard_entry import read_entry
    from dcrb_ros.exam.verification import differences
    from dcrb_ros.runtime.exit_status import print_error
    from dcrb_ros.schema.printable import printable

    try:
        entry = read_entry(path)
    except Refusal as refusal:
        # The entries after it are verified, too.
        print_error("dcrb", str(refusal))
        return False
    if entry.scenarios_sha256 != exam.digest and (not exam.seal or entry.sealed_sha256 != exam.seal):
        print(f"{path}: DOES NOT AGREE, its scenarios are of another exam, '{printable(entry.exam)}': give entries of this one")
        return False
    flaws = list(differences(entry, exam))
    more = f" (and {len(flaws) - 1} more)" if len(flaws) > 1 else ""
    result = f"DOES NOT AGREE, {printable(flaws[0])}{more}: make it again with dcrb score --entry" if flaws else "agrees"
    print(f"{path}: {result}")
    return not flaws


@app.command()
def table(
    entries: Annotated[Path, typer.Argument(help="Folder with entries of dcrb score --entry.")],
    output: Annotated[Path | None, typer.Option("--output", "-o", help="Folder to write to. Default: the folder of the entries.")] = None,
    measured: Annotated[
        Path | None, typer.Option(help="Folder with entries of the same detectors on measured recordings, to compare with.")
    ] = None,
) -> None:
    """Write the leaderboard of a folder of entries: leaderboard.md, leaderboard.html and a figure leaderboard-N.png for each exam.

    Those of an earlier table in the folder are replaced, and its other figures are removed.

    Example: dcrb exam table entries --measured measured_entries
    """
    from dcrb_ros.exam.leaderboard import markdown, page, read_boards
    from dcrb_ros.exam.leaderboard_figure import board_figure

    boards, folder = read_boards(entries, measured), output or entries
    figures = [f"leaderboard-{number}.png" for number in range(1, len(boards) + 1)]
    names = ("leaderboard.md", "leaderboard.html", *figures)
    for name in names if folder.is_dir() else ():
        check_output("--output", folder / name)
    with whole_folder(folder, names[0]) as written:
        for board, figure in zip(boards, figures, strict=True):
            board_figure(board).savefig(written / figure)
        (written / names[0]).write_bytes(markdown(boards, figures).encode())
        (written / names[1]).write_bytes(page(boards, figures).encode())
    for name in names:
        print(folder / name)
    _remove_other_figures(folder, figures)


def _remove_other_figures(folder: Path, figures: Sequence[str]) -> None:
    """Remove the figures of a longer table that was written to the folder before, and print their names."""
    for file in folder.glob("leaderboard-*.png"):
        if re.fullmatch(r"leaderboard-[1-9]\d*\.png", file.name) and file.name not in figures and file.is_file():
            try:
                file.unlink()
            except OSError as error:
                raise Refusal(f"{file} is of an earlier table and cannot be removed: {error.strerror}; remove it") from None
            print(f"{file}: removed, it is of an earlier table")


@app.command()
def agreement(
    exam: Annotated[Path, typer.Argument(help="Folder with entries of dcrb score EXAM --entry.")],
    measured: Annotated[Path, typer.Argument(help="Folder with entries of dcrb score --measured DIR --entry, with the same --name.")],
) -> None:
    """Print the rank correlation between the scores of detectors in an exam and on measured recordings.

    Example: dcrb exam agreement entries measured_entries
    """
    from dcrb_ros.exam.agreement import agreement as rank_agreement
    from dcrb_ros.exam.leaderboard import read_entries
    from dcrb_ros.exam.marking import marking_of
    from dcrb_ros.exam.statistics import CONFIDENCE
    from dcrb_ros.runtime.terminal import console, table
    from dcrb_ros.schema.printable import printable

    entries = read_entries(exam)
    ranks, marking = rank_agreement(entries, read_entries(measured)), marking_of(entries[0])
    each = zip(ranks.detectors, ranks.exam, ranks.measured, strict=True)
    rows = [(printable(name), f"{score:.1f}", f"{share:.0f}") for name, score, share in each]
    console().print(table("", ("detector", f"{marking.name} [{marking.unit}]", "correct on measured recordings [%]"), rows))
    for name, value in (("Kendall's tau-b", ranks.kendall), ("Spearman's rho", ranks.spearman)):
        print(f"{name} {value.value:.2f} ({CONFIDENCE:.0%} bootstrap interval {value.low:.2f} to {value.high:.2f})")


app.command()(replica)
app.command()(predictivity)
