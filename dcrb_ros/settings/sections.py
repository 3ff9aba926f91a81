"""The parameters of a node in a file: plain groups, or the sections of a ROS parameter file.

A section belongs to the nodes that its name matches, where ``*`` stands for one part of a name and ``**`` for any number of them. Of two
sections for a node, the later one in the file overrides the other. Both are as in ROS.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from dcrb_ros.schema.refusal import Refusal, nearest

KEY = "ros__parameters"
"""The key below the name of a node in a ROS parameter file."""
BENCH = "/dcrb"
"""Namespace of the bench."""
NODES = ("simulator", "fault_detector", "replayer", "viewer")
"""Nodes of the bench."""
OF_ROS = ("use_sim_time", "start_type_description_service")
"""Parameters that every node of ROS has; `ros2 param dump` writes them too."""
SHAPE = "give groups such as 'operating: {speed: 100.0}', or a ROS parameter file that begins with '/**:' and 'ros__parameters:'"

Tree = Mapping[Any, Any]


def parameters_of(tree: Any, node: str, source: str, *, of_ros: bool = False) -> list[Tree]:
    """Return the trees of parameters that a file has for a node; a later one overrides those before it.

    Args:
        tree: the file as parsed from YAML.
        node: one of `NODES`.
        source: the file's name in error messages.
        of_ros: whether to include the parameters that every node of ROS has.

    Raises:
        Refusal: the file has no parameters for the node, or something that no node of the bench reads.
    """
    if not isinstance(tree, Mapping) or not tree:
        raise Refusal(f"{source} is not a file of parameters: {SHAPE}")
    if not _has_sections(tree):
        _refuse_names_of_nodes(tree, source)
        return [tree]
    sections = list(_sections(tree, "", source))
    for name, _ in sections:
        if not any(_is_for(name, known) for known in NODES):
            last = name.rpartition("/")[2]
            raise Refusal(
                f"{source}: no node of the bench reads the section '{name}': use '/**', or a node in the namespace {BENCH} "
                f"({', '.join(NODES)}){nearest(last, NODES) if last not in NODES else ''}"
            )
    found = [parameters for name, parameters in sections if _is_for(name, node)]
    if not found:
        named = ", ".join(f"'{name}'" for name, _ in sections)
        raise Refusal(f"{source} has no parameters for the node '{node}'; its sections are {named}: add '/**/{node}:', or use '/**:'")
    return [{key: value for key, value in parameters.items() if of_ros or key not in OF_ROS} for parameters in found]


def _has_sections(tree: Tree) -> bool:
    """Return whether a tree has the form of a ROS parameter file, at least in part."""
    return KEY in tree or any(isinstance(value, Mapping) and _has_sections(value) for value in tree.values())


def _refuse_names_of_nodes(tree: Tree, source: str) -> None:
    """Refuse a plain file that names a node."""
    for name in tree:
        if str(name).startswith("/") or name in NODES:
            raise Refusal(f"{source}: '{name}' must contain '{KEY}:' and nothing else, or leave it out and give the groups alone")


def _sections(tree: Tree, namespace: str, source: str) -> Iterator[tuple[str, Tree]]:
    """Yield name and parameters of each section in the order of the file."""
    if KEY in tree:
        raise Refusal(f"{source}: '{KEY}:' must be below the name of a node, such as '/**:'")
    for part, value in tree.items():
        name = f"{namespace}/{part}" if namespace else str(part)
        if not isinstance(value, Mapping) or not _has_sections(value):
            beside = next(_names(tree, namespace), "")
            raise Refusal(f"{source}: '{name}' is beside the section '{beside}', so no node would read it: move it below '{KEY}:'")
        if KEY not in value:
            yield from _sections(value, name, source)
            continue
        if set(value) != {KEY}:
            raise Refusal(f"{source}: '{name}' must contain '{KEY}:' and nothing else")
        if not isinstance(value[KEY], Mapping):
            raise Refusal(f"{source}: '{name}' has no parameters below '{KEY}:'; add some, or remove the section")
        yield name, value[KEY]


def _names(tree: Tree, namespace: str) -> Iterator[str]:
    """Yield the names of the sections in a tree."""
    for part, value in tree.items():
        if isinstance(value, Mapping):
            name = f"{namespace}/{part}" if namespace else str(part)
            yield from [name] if KEY in value else _names(value, name)


def _is_for(section: str, node: str) -> bool:
    """Return whether a section's name matches a node of the bench; the bare name of the node does, too."""
    bare = "/" + section.lstrip("/")
    pattern = re.escape(bare).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"/\w+")
    return bare == f"/{node}" or re.fullmatch(pattern, f"{BENCH}/{node}") is not None
