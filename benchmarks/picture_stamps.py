"""Stamps of the pictures in docs/images: the things that a picture shows, and whether they have changed since it was made.

``docs/images/pictures.json`` has, for each picture, the command that makes it, the date on which it was made, and a digest of each thing
that it shows:

* ``bench NAME KEY=VALUE ...``: the parameters of a shipped configuration that differ from their defaults
* ``samples CASE``: a fingerprint of the model, from ``tests/unchanged``
* ``file PATH``: the content of a file, of YAML the values
* ``detector FOLDER``: the detector's verdict on each recording of a folder, its confidence, and the scores of suspected faults
* ``drawing PATH[:FUNCTION]``: texts, numbers and colours of a source file, a folder or a function; names and docstrings may change
"""

from __future__ import annotations

import ast
import functools
import hashlib
import json
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import yaml

from dcrb_ros.diagnosis.detection import detect
from dcrb_ros.recordings.reader import Recording
from dcrb_ros.settings.files import load_configuration

ROOT = Path(__file__).resolve().parents[1]
IMAGES = ROOT / "docs/images"
MANIFEST = IMAGES / "pictures.json"


def digest_of(value: Any) -> str:
    """Return a short hash of a value that JSON can represent."""
    return hashlib.sha256(json.dumps(value, sort_keys=True, default=str).encode()).hexdigest()[:16]


def bench(text: str) -> str:
    """Return the digest of a shipped configuration with changed parameters: ``NAME KEY=VALUE ...``."""
    name, *settings = text.split()
    return digest_of(load_configuration(name, settings).model_dump(exclude_defaults=True))


@functools.cache
def fingerprints() -> dict[str, Any]:
    """Return the fingerprints of the model by case."""
    return dict(json.loads((ROOT / "tests/unchanged/fingerprints.json").read_text(encoding="utf-8"))["cases"])


def samples(case: str) -> str:
    """Return the fingerprint of the samples of a case of `tests/unchanged`."""
    return str(fingerprints()[case]["samples"])


def file(path: str) -> str:
    """Return the digest of a file of the repository; of a YAML file that of its values, so that comments may change."""
    data = (ROOT / path).read_bytes()
    return digest_of(yaml.safe_load(data)) if path.endswith(".yaml") else hashlib.sha256(data).hexdigest()[:16]


@functools.cache
def detector(recordings: str) -> str:
    """Return the digest of the detector's verdict and confidence on each recording of a folder, and of its scores above the thresholds.

    A rule that finds nothing in these recordings does not change it.
    """
    verdicts = {}
    for path in sorted(path for path in (ROOT / recordings).iterdir() if path.is_dir()):
        result = detect(Recording(path))
        suspected = {fault: round(score, 1) for fault, score in result.last.scores.items() if score >= 0.0}
        verdicts[path.name] = result.verdict, round(result.confidence, 2), suspected
    return digest_of(verdicts)


def drawing(path: str) -> str:
    """Return the digest of the constants in a source file, or in those of a folder, or in one function: ``PATH:FUNCTION``."""
    source, _, function = path.partition(":")
    files = sorted((ROOT / source).rglob("*.py")) if (ROOT / source).is_dir() else [ROOT / source]
    trees: Iterable[ast.AST] = [ast.parse(file.read_text(encoding="utf-8")) for file in files]
    if function:
        trees = [node for tree in trees for node in ast.walk(tree) if isinstance(node, ast.FunctionDef) and node.name == function]
    return digest_of(sorted(repr(constant) for tree in trees for constant in constants(tree)))


def constants(tree: ast.AST) -> Iterator[Any]:
    """Yield the constants of a syntax tree, but no docstrings."""
    texts = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    yield from (node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in texts)


KINDS: dict[str, Callable[[str], str]] = {"bench": bench, "samples": samples, "file": file, "detector": detector, "drawing": drawing}


def digests(shown: Iterable[str]) -> dict[str, str]:
    """Return the present digest of each thing shown: ``KIND TEXT``."""
    return {subject: KINDS[subject.split(" ", 1)[0]](subject.split(" ", 1)[1]) for subject in shown}


def stamps() -> dict[str, Any]:
    """Return the manifest of the pictures by file name."""
    return dict(json.loads(MANIFEST.read_text(encoding="utf-8")))


def write_stamps(manifest: Mapping[str, Any]) -> None:
    """Write the manifest, sorted by file name."""
    MANIFEST.write_text(json.dumps(dict(sorted(manifest.items())), indent=1) + "\n", encoding="utf-8")


def stamp(command: str, shown: Iterable[str]) -> dict[str, Any]:
    """Return the stamp of a picture that is made now."""
    return {"command": command, "made": time.strftime("%Y-%m-%d", time.gmtime()), "shows": digests(shown)}


def changed(stamp: Mapping[str, Any]) -> list[str]:
    """Return the things that a picture shows and that have changed since it was made."""
    present = digests(stamp["shows"])
    return [subject for subject, digest in stamp["shows"].items() if present[subject] != digest]
