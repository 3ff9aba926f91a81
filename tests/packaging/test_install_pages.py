"""The installation beside ROS packages: the page names what the package needs."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from xml.etree import ElementTree

from packaging.requirements import Requirement
from packaging.version import Version

ROOT = Path(__file__).parents[2]
UBUNTU, _, PIXI = (ROOT / "docs" / "how-to" / "install-with-ros.md").read_text(encoding="utf-8").partition("## RoboStack and pixi")


def needed(name: str) -> dict[str, Requirement]:
    """Return the requirements of a list in setup.py, ``install_requires`` or an extra, by name."""
    tree = ast.parse((ROOT / "setup.py").read_text(encoding="utf-8"))
    keywords = [(node.arg, node.value) for node in ast.walk(tree) if isinstance(node, ast.keyword)]
    extras = [
        (ast.literal_eval(key), value)
        for node in ast.walk(tree)
        if isinstance(node, ast.Dict)
        for key, value in zip(node.keys, node.values, strict=True)
        if isinstance(key, ast.Constant)
    ]
    (found,) = (value for key, value in [*keywords, *extras] if key == name)
    return {requirement.name: requirement for requirement in map(Requirement, ast.literal_eval(found))}


def of_packages() -> set[str]:
    """Return the requirements that rosdep installs from the system's packages."""
    keys = {element.text or "" for element in ElementTree.parse(ROOT / "package.xml").getroot().iter("exec_depend")}
    return {key.removeprefix("python3-") for key in keys if key.startswith("python3-")} | {"pillow"}  # matplotlib needs pillow


def test_the_virtual_environment_has_what_the_system_does_not() -> None:
    given = {requirement.name: requirement for requirement in map(Requirement, re.findall(r"\"([a-z0-9-]+>=[0-9.]+)\"", UBUNTU))}
    wanted = needed("install_requires") | needed("sweep")
    assert wanted.keys() - given.keys() <= of_packages() | {"yaml", "pyyaml"}
    assert given.keys() - wanted.keys() == {"coverage"}  # see the page
    for name, requirement in wanted.items():
        lowest = [Version(bound.version) for bound in given[name].specifier] if name in given else []
        assert all(version in requirement.specifier for version in lowest), name


def test_pixi_is_given_every_requirement() -> None:
    words = set(re.findall(r"[a-z0-9-]+", PIXI))
    assert needed("install_requires").keys() - words <= {"numpy", "pillow", "pyyaml"}  # numba, matplotlib and ROS bring them


def test_the_package_declares_what_has_a_key_of_rosdep() -> None:
    # rosdep knows no key for these; the virtual environment of the page has them.
    assert needed("install_requires").keys() - of_packages() <= {"mcap", "pyarrow", "pyyaml", "rerun-sdk", "rosbags"}
    tests = {element.text for element in ElementTree.parse(ROOT / "package.xml").getroot().iter("test_depend")}
    assert {"python3-hypothesis", "python3-pytest", "python3-pytest-timeout"} <= tests
