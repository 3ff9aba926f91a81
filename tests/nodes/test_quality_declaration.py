"""The quality declaration and the manifest agree, and the files that it refers to exist."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

ROOT = Path(__file__).parents[2]
DECLARATION = (ROOT / "QUALITY_DECLARATION.md").read_text(encoding="utf-8")
MANIFEST = ElementTree.parse(ROOT / "package.xml").getroot()


def test_the_declared_version_is_that_of_the_package() -> None:
    (declared,) = re.findall(r"\| 1\.ii stable version \| (\S+) \| (yes|no) \|", DECLARATION)
    version = MANIFEST.findtext("version", "")
    assert declared == (version, "yes" if int(version.split(".")[0]) >= 1 else "no")


def test_the_manifest_and_the_readme_refer_to_the_declaration() -> None:
    assert MANIFEST.findtext("export/quality_declaration") == "QUALITY_DECLARATION.md"
    assert "(QUALITY_DECLARATION.md)" in (ROOT / "README.md").read_text(encoding="utf-8")


def test_every_file_in_the_declaration_exists() -> None:
    files = [target for target in re.findall(r"\]\(([^)]+)\)", DECLARATION) if not target.startswith("https://")]
    assert len(files) > 5
    assert [name for name in files if not (ROOT / name).is_file()] == []
