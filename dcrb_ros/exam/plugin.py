"""Detectors written in Python, given by a module or a file and a class, or by the name of an entry point."""

from __future__ import annotations

import importlib
import importlib.metadata
import importlib.util
import sys
from collections.abc import Mapping
from functools import partial
from pathlib import Path
from typing import Any

from dcrb_ros.exam.running_detector import DetectorFactory
from dcrb_ros.schema.refusal import Refusal, nearest

VARIANTS = "VARIANTS"
"""Mapping in the module of a detector from the name of each member of its family to the settings of the class."""
GROUP = "dcrb_ros.detectors"
"""Group of the entry points with which an installed package offers detectors."""


def load_plugin(given: str) -> DetectorFactory:
    """Return the detector class given as ``module:Class``, ``file.py:Class`` or the name of an entry point.

    ``file.py:Class[MEMBER]`` has the settings ``VARIANTS["MEMBER"]`` of its module as keyword arguments.

    Raises:
        Refusal: there is no such module, file, class, member or entry point, or it cannot be imported or called.
    """
    bare, bracket, member = given.removesuffix("]").partition("[") if given.endswith("]") and "[" in given else (given, "", "")
    module_name, colon, name = bare.rpartition(":")
    if not colon:
        offered = {point.name: point for point in importlib.metadata.entry_points(group=GROUP)}
        if given not in offered:
            known = f"; installed are {', '.join(offered)}{nearest(given, offered)}" if offered else ""
            raise Refusal(f"--python {given} is not an installed detector: give MODULE:CLASS or FILE.py:CLASS{known}")
        module_name, _, name = offered[given].value.partition(":")
    if not (module_name and name):
        raise Refusal(f"--python {given} names no {'class' if module_name else 'module'}: give MODULE:CLASS or FILE.py:CLASS")
    module = load_module(given, module_name)
    factory: DetectorFactory | None = getattr(module, name, None)
    if factory is not None and not callable(factory):
        raise Refusal(f"--python {given}: {name} in {module_name} is {factory!r} and no class: give the name of a detector class in it")
    if factory is None:
        raise Refusal(
            f"--python {given}: {module_name} has no class {name}{nearest(name, vars(module))}: give the name of a detector class in it"
        )
    if not bracket:
        return factory
    variants = variants_of(given, module)
    if member not in variants:
        known = f"{', '.join(variants) or 'none'}{nearest(member, variants)}"
        raise Refusal(f"--python {given}: {module_name} has no member '{member}' in {VARIANTS} (known: {known}): give one of them")
    return partial(factory, **variants[member])


def variants_of(given: str, module: Any) -> Mapping[str, Mapping[str, Any]]:
    """Return the settings of each member of the family in a module; none if it has no `VARIANTS`.

    Raises:
        Refusal: they are no mapping from names to settings.
    """
    variants = getattr(module, VARIANTS, {})
    if not (_named(variants) and all(map(_named, variants.values()))):
        raise Refusal(
            f"--python {given}: {VARIANTS} is {variants!r}: give a mapping from the name of each member to the settings of its class, such "
            "as {'published': {}, 'short window': {'window': 0.5}}"
        )
    named: Mapping[str, Mapping[str, Any]] = variants
    return named


def _named(values: Any) -> bool:
    """Return whether values have names."""
    return isinstance(values, Mapping) and all(isinstance(name, str) for name in values)


def load_module(given: str, name: str) -> Any:
    """Return the module of a name or a file; see `load_plugin`."""
    try:
        if not name.endswith(".py"):
            return importlib.import_module(name)
        path = Path(name).resolve()
        if not path.is_file():
            raise Refusal(f"--python {given}: there is no file {name}")
        # Modules beside the file can be imported, as if it were run.
        if str(path.parent) not in sys.path:
            sys.path.insert(0, str(path.parent))
        module = importlib.import_module(path.stem) if path.stem.isidentifier() else None
        # Another module may have been imported under this name, such as one of the standard library.
        return module if module is not None and Path(module.__file__ or "").resolve() == path else _from_file(path)
    except Refusal:
        raise
    except (Exception, SystemExit) as error:
        text = f": {error}" if str(error) else ""
        raise Refusal(f"--python {given} cannot be imported: {type(error).__name__}{text}") from None


def _from_file(path: Path) -> Any:
    """Return the module of a file whose name cannot be imported."""
    description = importlib.util.spec_from_file_location(str(path), path)
    if description is None or description.loader is None:
        raise ImportError(f"{path} is not a Python file")
    module = sys.modules[str(path)] = importlib.util.module_from_spec(description)  # where dataclasses look for the module of a class
    description.loader.exec_module(module)
    return module
