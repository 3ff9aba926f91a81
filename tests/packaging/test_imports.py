"""Imports between the files of the package, those for type checkers included."""

from __future__ import annotations

import pytest

ROOT = "dcrb_ros"


def test_no_files_import_each_other_in_a_circle() -> None:
    grimp = pytest.importorskip("grimp")
    graph = grimp.build_graph(ROOT, cache_dir=None)
    # The package itself names the public API for type checkers.
    modules = graph.modules - {ROOT}
    assert "dcrb_ros.settings.configuration" in graph.find_modules_directly_imported_by("dcrb_ros.settings.files")
    circular = {m for m in modules if any(graph.chain_exists(importer=i, imported=m) for i in graph.find_modules_directly_imported_by(m))}
    assert not circular
