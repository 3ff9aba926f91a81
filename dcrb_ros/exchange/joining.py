"""Files of one measurement read as one: the same channels in each, one after the other."""

from __future__ import annotations

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

import numpy as np

from dcrb_ros.exchange.files import ExternalFile, channel, read_external
from dcrb_ros.exchange.text_table import Array
from dcrb_ros.schema.arrays import Floats
from dcrb_ros.schema.refusal import Refusal

RATES = ("fs", "sr", "sampling_rate", "sample_rate", "samplerate")
"""Names of the sampling rate beside data."""
TIMES = ("t", "time", "time_s", "time [s]", "time(s)", "seconds")
"""Names of the time of each sample."""

JUMP = 3.0
"""Least jump of a time relative to its usual step [-]; a time that is rounded to a few digits advances by up to two usual steps."""


class JoinedFiles:
    """The channels of one or more files.

    Raises:
        Refusal: a file cannot be read, or the files state different sampling rates or full scales.
    """

    def __init__(self, files: Sequence[Path]) -> None:
        self.files = tuple(files)
        self._externals = [read_external(file) for file in files]
        self.rate = self._same("sampling rates", lambda external: external.rate)
        self.full_scale = self._same("full scales", lambda external: external.full_scale)

    def __str__(self) -> str:
        return str(self.files[0]) if len(self.files) == 1 else f"{self.files[0]} and {len(self.files) - 1} more"

    def _same(self, quantity: str, value_of: Callable[[ExternalFile], float | None]) -> float | None:
        stated = {value_of(external): file for file, external in zip(self.files, self._externals, strict=True)}
        if len(stated) > 1:
            (first, file), (second, other) = list(stated.items())[:2]
            raise Refusal(f"{file} and {other} have different {quantity}, {first} and {second}: import them separately")
        return next(iter(stated))

    def contradiction(self, rate: float, beside: str | int, others: Collection[str | int]) -> str:
        """Return a sentence on a number or a time in the files that belongs to another sampling ``rate`` [Hz], or the empty string.

        In a structure, only the fields ``beside`` the channel are compared. A time may be in s, ms or us, and is as long as the channel. It
        must increase, unless it is one of the ``others`` that are described. Of a bare ``t``, which may be a temperature, only one that
        increases at most samples is compared.
        """
        for file, name, values in self._beside(beside, RATES):
            if values.size == 1 and not np.isclose(values[0], rate, rtol=1e-3):
                return f"'{name}' is {values[0]:g} in {file}"
        for file, name, values in self._beside(beside, TIMES, others):
            differences = np.diff(values)
            rising, median = differences[differences > 0.0], float(np.median(differences)) if values.size > 2 else np.nan
            if not np.isfinite(median) or (median <= 0.0 and name.lower().rpartition(".")[2] == "t"):
                continue
            if not len(rising):
                return f"'{name}' does not increase in {file}"
            # The median bridges gaps in the time, the mean of its steps without gaps its rounding to a few digits.
            steps = differences[(differences >= 0.0) & (differences <= JUMP * max(median, float(rising.min())))]
            mean, uncertain = float(steps.mean()), float(rising.min()) / len(steps) if median == 0.0 else 0.0
            scales = np.array([[1.0], [1e3], [1e6]])
            if not np.isclose(np.array([median, mean]) * rate, scales, rtol=1e-2, atol=uncertain * rate).any():
                return f"'{name}' advances by {median or mean:g} for each sample in {file}"
        return ""

    def jump(self, beside: str | int) -> str:
        """Return a sentence on the first jump of a time ``beside`` the channel, where samples may be missing, or the empty string."""
        for file, name, values in self._beside(beside, TIMES):
            steps = np.diff(values)
            if not len(rising := steps[steps > 0.0]):
                continue
            usual = max(float(np.median(steps)), float(rising.min()))  # a rounded time rises at some samples only
            jumps = np.flatnonzero((steps > JUMP * usual) | (steps < 0.0))
            if len(jumps):
                return f"'{name}' in {file} advances by {steps[jumps[0]]:g} after sample {jumps[0]}, but by {usual:g} elsewhere"
        return ""

    def _beside(self, beside: str | int, words: Sequence[str], others: Collection[str | int] = ()) -> Iterator[tuple[Path, str, Floats]]:
        """Yield the file, name and values of each channel with one of the names ``words``, at the top or in the structure of another.

        With several values it is as long as the channel ``beside`` it, and none of the ``others``.
        """
        for file, external in zip(self.files, self._externals, strict=True):
            group = str(matching(external, file, beside)).lower().rpartition(".")[0]
            described = {matching(external, file, other) for other in others}
            described |= {external.names[other - 1] for other in described if isinstance(other, int) and 0 < other <= len(external.names)}
            for name in external.names:
                owner, _, word = name.lower().rpartition(".")
                if owner in ("", group) and word in words and name not in described:
                    with suppress(Refusal):
                        values = channel(external, file, name).astype(np.float64)
                        if values.size == 1 or len(values) == len(channel(external, file, matching(external, file, beside))):
                            yield file, name, values

    def parts(self, name: str | int, *, nan: bool = False) -> list[Array]:
        """Return a channel of each file as the file has it, shape (files,) of (samples,).

        Raises:
            Refusal: a file lacks it, or it has values that are infinite, or NaN unless ``nan`` are allowed.
        """
        return [
            _finite(channel(external, file, matching(external, file, name)), file, name, nan=nan)
            for file, external in zip(self.files, self._externals, strict=True)
        ]

    def numbers(self, name: str | int, *, nan: bool = False) -> list[Floats]:
        """Return a channel of each file in double precision; see `parts`."""
        return [part.astype(np.float64, copy=False) for part in self.parts(name, nan=nan)]


def matching(external: ExternalFile, file: Path, name: str | int) -> str | int:
    """Return the name of a channel; a ``*`` in it matches any characters of the name of a variable.

    Raises:
        Refusal: no variable or several have such a name.
    """
    if isinstance(name, int) or "*" not in name or name in external.names:
        return name
    whole = _alike(name, external.names)
    head, dot, rest = name.partition(".")
    parts = [] if whole else _alike(head, dict.fromkeys(known.partition(".")[0] for known in external.names))
    matches = whole or [f"{part}{dot}{rest}" for part in parts]
    if len(matches) != 1:
        has = f"the channels {', '.join(matches[:8])}" if matches else "no channel"
        known = ", ".join(external.names[:20]) or "none"
        raise Refusal(f"{file} has {has} like '{name}', but one is needed (available: {known}): give its whole name")
    return matches[0]


def _alike(name: str, known: Iterable[str]) -> list[str]:
    """Return the ``known`` names that ``name`` with its ``*`` stands for."""
    pattern = re.compile(".*".join(re.escape(part) for part in name.split("*")))
    return [word for word in known if pattern.fullmatch(word)]


def _finite(values: Array, file: Path, name: str | int, *, nan: bool) -> Array:
    bad = int(np.count_nonzero(np.isinf(values) if nan else ~np.isfinite(values)))
    if bad:
        raise Refusal(f"{file}: {bad} of {len(values)} samples of '{name}' are not finite numbers: remove them first")
    return values
