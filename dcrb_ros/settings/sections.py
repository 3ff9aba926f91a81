"""The parameters of a node in a file: plain groups, or the sections of a ROS parameter file.

A section belongs to the nodes that its name matches, where ``*`` stands for one part of a name and ``**`` for any number of them. Of two
sections for a node, the later one in the file overrides the other. Both are as in ROS.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Any

from dcrb_ros.schema.refusal import nearest

KEY = "ros__parameters"
"""The key below the name of a node in a ROS parameter file."""
BENCH = "/dcrb"
"""Namespace of the bench."""
NODES = ("simulator", "fault_detector", "hot_box_detector", "replayer", "viewer", "vehicle_simulator", "vehicle_detector")
"""Nodes of the bench."""
ALL = "/**"
"""Section for every node."""
QOS_OVERRIDES = "qos_overrides"
"""Group of the parameters with the quality of service of publishers and subscriptions."""
OF_ROS = ("use_sim_time", "start_type_description_service", QOS_OVERRIDES)
"""Parameters that every node of ROS has; `ros2 param dump` writes them too."""
SHAPE = "give groups such as 'operating: {speed: 100.0}', or a ROS parameter file that begins with '/**:' and 'ros__parameters:'"

Tree = Mapping[Any, Any]


def read_sections(tree: Any, node: str, *, of_ros: bool = False) -> tuple[list[Tree], list[str]]:
    """Return the trees of parameters that a file has for a node, and a sentence for everything in it that no node reads.

    A later tree overrides those before it. With such sentences, the trees also contain what was probably meant for the node, for its values
    to be checked.

    Args:
        tree: the file as parsed from YAML.
        node: one of `NODES`.
        of_ros: whether to include the parameters that every node of ROS has.
    """
    if not isinstance(tree, Mapping) or not tree:
        return [], [f"this is not a file of parameters: {SHAPE}"]
    if not _has_sections(tree):
        return [tree], _names_of_nodes(tree)
    wrong: list[str] = []
    sections = list(_sections(tree, "", wrong))
    for name in dict.fromkeys(name for name, _ in sections):
        if not any(_is_for(name, known) for known in NODES):
            last = name.rpartition("/")[2]
            wrong.append(
                f"no node of the bench reads the section '{name}': use '/**', or a node in the namespace {BENCH} "
                f"({', '.join(NODES)}){nearest(last, NODES) if last not in NODES else ''}"
            )
    trees = [parameters for name, parameters in sections if _is_for(name, node) or _resembles(name, node)]
    if not trees and not wrong:
        named = ", ".join(f"'{name}'" for name, _ in sections)
        wrong.append(f"it has no parameters for the node '{node}'; its sections are {named}: add '/**/{node}:', or use '/**:'")
    return [{key: value for key, value in parameters.items() if of_ros or key not in OF_ROS} for parameters in trees], wrong


def _has_sections(tree: Tree) -> bool:
    """Return whether a tree has the form of a ROS parameter file, at least in part."""
    return KEY in tree or any(isinstance(value, Mapping) and _has_sections(value) for value in tree.values())


def _names_of_nodes(tree: Tree) -> list[str]:
    """Return a sentence for each name of a node in a plain file."""
    named = [name for name in tree if _names_node(name)]
    return [f"'{name}' must contain '{KEY}:' and nothing else, or leave it out and give the groups alone" for name in named]


def _names_node(key: Any) -> bool:
    """Return whether a key is the name of a node."""
    return str(key).startswith("/") or key in NODES


def _sections(tree: Tree, namespace: str, wrong: list[str]) -> Iterator[tuple[str, Tree]]:
    """Yield name and parameters of each section in the order of the file; add a sentence to ``wrong`` for what belongs to none."""
    if KEY in tree:
        wrong.append(f"'{KEY}:' must be below the name of a node, such as '/**:'")
        if isinstance(tree[KEY], Mapping):
            yield ALL, tree[KEY]
    for part, value in tree.items():
        name = f"{namespace}/{part}" if namespace else str(part)
        if part == KEY:
            continue
        if not isinstance(value, Mapping) or not _has_sections(value):
            beside = next(_names(tree, namespace), ALL)
            wrong.append(f"'{name}' is beside the section '{beside}', so no node would read it: move it below '{KEY}:'")
            if not namespace and not _names_node(part):
                yield ALL, {part: value}
        elif KEY not in value:
            yield from _sections(value, name, wrong)
        else:
            yield from _section(name, value, wrong)


def _section(name: str, section: Tree, wrong: list[str]) -> Iterator[tuple[str, Tree]]:
    """Yield name and parameters of a section, and then what is beside them; see `_sections`."""
    beside = {key: value for key, value in section.items() if key != KEY}
    if beside:
        wrong.append(f"'{name}' must contain '{KEY}:' and nothing else")
    if isinstance(section[KEY], Mapping):
        yield name, section[KEY]
    else:
        wrong.append(f"'{name}' has no parameters below '{KEY}:'; add some, or remove the section")
    if beside:
        yield name, beside


def _names(tree: Tree, namespace: str) -> Iterator[str]:
    """Yield the names of the sections in a tree."""
    for part, value in tree.items():
        if isinstance(value, Mapping):
            name = f"{namespace}/{part}" if namespace else str(part)
            yield from [name] if KEY in value else _names(value, name)


def _resembles(section: str, node: str) -> bool:
    """Return whether a section for no node of the bench is probably meant for this one."""
    return not any(_is_for(section, known) for known in NODES) and f"'{node}'" in nearest(section.rpartition("/")[2], NODES)


def _is_for(section: str, node: str) -> bool:
    """Return whether a section's name matches a node of the bench; the bare name of the node does, too."""
    bare = "/" + section.lstrip("/")
    pattern = re.escape(bare).replace(r"/\*\*", r"(/\w+)*").replace(r"/\*", r"/\w+")
    return bare == f"/{node}" or re.fullmatch(pattern, f"{BENCH}/{node}") is not None
