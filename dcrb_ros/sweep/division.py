"""The division of conditions into splits: bearings and machines are kept apart, and the splits of an earlier, smaller sweep are kept."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.sweep.design import Axes, Span
from dcrb_ros.sweep.identity import BEARING_ID, IDENTITIES, MACHINE
from dcrb_ros.sweep.sweep_file import EXTENDED, Extent, Shares

TOLERANCE = 0.25
"""Largest change of the share of a split by machines that are kept apart by default [-]: three sensors do not make three splits."""
REMEDIES = {
    BEARING_ID: ("bearing", "vary surfaces.seed, with surfaces.law: profile"),
    MACHINE: ("machine", "vary structure.seed, with a structure.housing or structure.modes above 0"),
    "track.seed": ("track", "vary track.seed"),
    "paths.seed": ("cross-talk path", "vary paths.seed"),
}
"""Noun of each identity and of each seed that vehicles may share, and how to get more of them."""


class Unit(NamedTuple):
    """A condition with the bearing and the machine on which it is simulated, as hashes."""

    condition: str
    bearing_id: str
    machine: str


class Division(NamedTuple):
    """The division of a sweep."""

    splits: Mapping[str, str]
    """Split of each condition."""
    shared: Mapping[str, int]
    """Number of bearings and machines in more than one split, by the name of the identity; without those that are 0 [-]."""


def batches(counts: Sequence[Extent], last: int) -> list[tuple[int, int]]:
    """Return first number and number after the last of each part of a sweep that was extended at ``counts`` to ``last``.

    Raises:
        Refusal: the counts do not rise.
    """
    ends = [0, *(count if isinstance(count, int) else 0 for count in counts), last]
    if counts and any(end <= begin for begin, end in itertools.pairwise(ends)):
        raise Refusal(f"{EXTENDED} = {list(counts)} is not a list of earlier, smaller numbers of points or lives below {last}: remove it")
    return list(itertools.pairwise(ends))


def checked_extents(earlier: Sequence[Extent], axes: Axes) -> list[Mapping[str, int]]:
    """Return the numbers of the first values of each axis of a grid, from the smallest grid to the whole one.

    Raises:
        Refusal: the numbers do not rise to those of the axes, or a range has another one.
    """
    whole = {key: 1 if isinstance(axis, Span) else len(axis.values) for key, axis in axes.items()}
    steps = [*(entry if isinstance(entry, dict) else {} for entry in earlier), whole]
    rises = all(
        first.keys() == second.keys() and first != second and all(0 < first[key] <= second[key] for key in first)
        for first, second in itertools.pairwise(steps)
    )
    if not rises:
        raise Refusal(
            f"{EXTENDED} = {list(earlier)} is not a list of earlier, smaller numbers of values of each axis of the grid: remove it"
        )
    # A range is written as one value.
    return [{key: len(axis.grid()) if isinstance(axis, Span) else step[key] for key, axis in axes.items()} for step in steps]


def divided(parts: Sequence[Collection[Unit]], shares: Shares) -> Division:
    """Divide the conditions of each part of a sweep; those of the earlier parts keep their splits.

    Without ``split.apart``, bearings and machines are kept apart, or bearings, or machines: the first of these that leaves no split empty
    and changes no share by more than its tolerance.

    Raises:
        Refusal: the conditions share too many of the identities of ``split.apart``.
    """
    apart: tuple[str, ...]
    if shares.apart is not None:
        apart = tuple(shares.apart)
        _check_groups(parts[0], shares, apart)
        split_of = _assigned(parts, shares, apart)
    else:
        plain = _part_of_each(_assigned(parts[:1], shares, ()))
        for apart, tolerance in (((BEARING_ID, MACHINE), TOLERANCE), ((BEARING_ID,), 1.0), ((MACHINE,), TOLERANCE), ((), 1.0)):
            kept = _part_of_each(_assigned(parts[:1], shares, apart))
            if all(abs(kept[split] - share) <= tolerance and bool(kept[split]) == bool(share) for split, share in plain.items()):
                break
        split_of = _assigned(parts, shares, apart)
    units = list(itertools.chain.from_iterable(parts))
    counts = {name: in_several((getattr(unit, name), split_of[unit.condition]) for unit in units) for name in IDENTITIES}
    shared = {name: count for name, count in counts.items() if count}
    broken = [name for name in apart if shared.get(name)]
    if broken and shares.apart is not None:
        raise Refusal(
            f"split.apart = {', '.join(shares.apart)}: the added conditions share a {REMEDIES[broken[0]][0]} with two splits: give a new "
            "folder for the larger data set"
        )
    return Division(split_of, shared)


def in_several(pairs: Iterable[tuple[Any, str]]) -> int:
    """Return how many names occur in more than one split; an empty one does not count."""
    splits: dict[str, set[str]] = {}
    for name, split in pairs:
        if name:
            splits.setdefault(name, set()).add(split)
    return sum(len(names) > 1 for names in splits.values())


def separation(shared: Mapping[str, int]) -> list[str]:
    """Return a sentence on bearings and one on machines: whether each is in one split only, as a list for the data card."""
    warned = warnings_of(shared)
    return [f"* {warned.get(name) or f'Every {REMEDIES[name][0]} is in one split (`{name}`).'}" for name in IDENTITIES]


def warnings_of(shared: Mapping[str, int], *, remedy: bool = True) -> dict[str, str]:
    """Return a sentence for each name of `REMEDIES` of which some are in more than one split, by the name."""
    return {
        name: f"{count} {noun}{' is' if count == 1 else 's are'} in more than one split ({name}), so that a classifier can recognise "
        f"{'it' if count == 1 else 'them'} in the test split" + (f": {way} to keep {noun}s apart." if remedy else ".")
        for name, (noun, way) in REMEDIES.items()
        if (count := shared.get(name, 0))
    }


def splits(conditions: set[str], shares: Shares) -> dict[str, str]:
    """Return the split of each condition: the sorted hashes are divided in proportion to the shares.

    Sorting makes the result independent of the iteration order of the set. Every split with a share above zero gets at least
    one condition if there are enough; if not, validation is left empty first.
    """
    order, given = sorted(conditions), {"train": shares.train, "validation": shares.validation, "test": shares.test}
    named = [(name, share) for name, share in given.items() if share > 0.0]
    if len(order) < len(named):
        named = [(name, share) for name, share in named if name != "validation"]
    if not order:
        return {}
    counts = [max(round(share * len(order)), 1) for _, share in named]
    while sum(counts[1:]) >= len(order) and max(counts[1:]) > 1:
        counts[counts.index(max(counts[1:]), 1)] -= 1
    # The training split absorbs the rounding error.
    counts[0] = max(len(order) - sum(counts[1:]), 1)
    names = itertools.chain.from_iterable([name] * count for (name, _), count in zip(named, counts, strict=True))
    return dict(zip(order, names, strict=False))


def grouped(parts: Sequence[Collection[Unit]], apart: Sequence[str]) -> dict[str, str]:
    """Return the group of each condition: those that share an identity of ``apart`` are in one, to avoid leakage."""
    parent: dict[str, str] = {}  # a disjoint-set forest (Tarjan 1975, J. ACM 22(2), 215-225)

    def root(name: str) -> str:
        while parent.setdefault(name, name) != name:
            parent[name] = name = parent[parent[name]]
        return name

    for unit in itertools.chain.from_iterable(parts):
        for name in apart:
            # The smaller name becomes the root, so that the order of the units does not matter.
            first, second = sorted((root(unit.condition), root(f"{name} {getattr(unit, name)}")))
            parent[second] = first
    return {unit.condition: root(unit.condition) for part in parts for unit in part}


def _assigned(parts: Sequence[Collection[Unit]], shares: Shares, apart: Sequence[str]) -> dict[str, str]:
    """Return the split of each condition, divided part by part; a new condition is in the split of an earlier one of its group."""
    split_of: dict[str, str] = {}
    for count, part in enumerate(parts, 1):
        groups = grouped(parts[:count], apart)
        known: dict[str, str] = {}
        for condition, split in split_of.items():
            known.setdefault(groups[condition], split)
        new = {groups[unit.condition] for unit in part} - known.keys()
        if new:
            known |= splits(new, shares)
        for unit in part:
            split_of.setdefault(unit.condition, known[groups[unit.condition]])
    return split_of


def _part_of_each(split_of: Mapping[str, str]) -> dict[str, float]:
    """Return the share of the conditions in each split [-]."""
    counts = Counter(split_of.values())
    return {split: counts[split] / len(split_of) for split in ("train", "validation", "test")}


def _check_groups(units: Collection[Unit], shares: Shares, apart: Sequence[str]) -> None:
    """Refuse ``split.apart`` where the conditions share too few bearings or machines to fill the splits."""
    group_of, conditions = grouped([units], apart), {unit.condition for unit in units}
    groups = len({group_of[condition] for condition in conditions})
    filled = sum(share > 0.0 for share in (shares.train, shares.validation, shares.test))
    if apart and groups < min(filled, len(conditions)):
        raise Refusal(
            f"split.apart = {', '.join(apart)}: the {len(conditions)} conditions make {groups} group(s) that share none of these, fewer "
            f"than the {filled} splits: {' and '.join(REMEDIES[name][1] for name in apart)}, or take more points"
        )
