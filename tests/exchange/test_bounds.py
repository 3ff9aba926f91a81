"""A small file that states large nested values is refused before they take memory, and large files take little more than their samples."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pyarrow as pa
import pytest
from pyarrow import parquet
from scipy.io import savemat

from dcrb_ros.exchange.files import WRITERS, channel, read_external
from dcrb_ros.exchange.pieces import unseen
from dcrb_ros.schema.refusal import Refusal

MOST = 300 * 1024
"""Most memory that a refusal may take beyond that of the interpreter with its libraries [KiB]."""

MOST_PER_SAMPLE = {"import": 50, "export": 95}
"""Most memory per sample of a conversion [byte]: acceleration in two axes, angle and index have 20, and the time has 8 more."""


def a_parquet_of_lists(path: Path) -> None:
    parquet.write_table(pa.table({"a": pa.array([[1.0] * 1000] * 100_000)}), path, compression="zstd")


def a_mat_with_a_structure(path: Path) -> None:
    savemat(path, {"s": {"x": np.zeros(60_000_000)}}, do_compression=True)


@pytest.mark.slow
@pytest.mark.parametrize(("write", "name"), [(a_parquet_of_lists, "x.parquet"), (a_mat_with_a_structure, "x.mat")])
def test_nested_values_are_bounded_before_they_are_loaded(write: object, name: str, tmp_path: Path) -> None:
    path = tmp_path / name
    write(path)  # type: ignore[operator]
    assert path.stat().st_size < 1_000_000
    with pytest.raises(Refusal, match=r"split it|has no column of numbers"):
        read_external(path)
    code = (
        "import resource, sys, scipy.io, pyarrow.parquet; from pathlib import Path; from dcrb_ros.exchange.files import read_external\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "try: read_external(Path(sys.argv[1]))\n"
        "except ValueError: print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)"
    )
    taken = subprocess.run([sys.executable, "-c", code, str(path)], capture_output=True, text=True, check=True, timeout=400.0).stdout
    assert int(taken) < MOST


def test_channels_beside_nested_values_are_read(tmp_path: Path) -> None:
    parquet.write_table(pa.table({"a": [1.0, 2.0], "words": ["x", "y"], "lists": [[1], [2, 3]]}), tmp_path / "x.parquet")
    external = read_external(tmp_path / "x.parquet")
    assert external.names == ("a",)
    assert channel(external, tmp_path / "x.parquet", "a").tolist() == [1.0, 2.0]
    for packed in (True, False):
        savemat(tmp_path / "x.mat", {"s": {"x": np.arange(100_000.0)}}, do_compression=packed)
        assert len(channel(read_external(tmp_path / "x.mat"), tmp_path / "x.mat", "s.x")) == 100_000


def test_an_array_that_a_mat_file_cannot_represent_is_refused_before_it_is_written(tmp_path: Path) -> None:
    time = np.broadcast_to(np.float64(0.0), 2**29)  # 2.9 hours at 51.2 kHz, which take no memory
    with pytest.raises(Refusal, match="cannot represent 4 GiB of 'time', 536870912 numbers: export it as npz or parquet"):
        WRITERS[".mat"](tmp_path / "x.mat", {"time": time}, {}, 51200.0, {}, unseen)
    assert not (tmp_path / "x.mat").exists()


def test_samples_that_a_wav_file_cannot_represent_are_refused_before_they_are_written(tmp_path: Path) -> None:
    samples = np.broadcast_to(np.float32(0.0), 2**29)  # 2.9 hours at 51.2 kHz, which take no memory
    columns = {"index": np.arange(2), "ax": samples, "ay": samples}
    with pytest.raises(Refusal, match="cannot represent 4294967296 bytes of samples, at most 4294966272: export it as npz or parquet"):
        WRITERS[".wav"](tmp_path / "x.wav", columns, {}, 51200.0, {}, unseen)
    assert not (tmp_path / "x.wav").exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", list(MOST_PER_SAMPLE))
def test_the_memory_of_a_conversion_is_bounded_by_that_of_its_samples(command: str, tmp_path: Path) -> None:
    samples = 2_000_000
    np.savez(tmp_path / "x.npz", a=np.random.default_rng(1).normal(size=samples).astype(np.float32))
    (tmp_path / "about.yaml").write_text(
        "{channels: {ax: a}, unit: g, sampling_rate: 48000, speed_rpm: 1797, orders: {FTF: 0.398, BPFO: 3.585, BPFI: 5.415, BSF: 2.357}}"
    )
    code = (
        "import resource, sys, pandas, scipy.io, pyarrow.parquet; from pathlib import Path\n"
        "from dcrb_ros.exchange.importing import WaveformImport; from dcrb_ros.exchange.export import export\n"
        "from dcrb_ros.exchange.plausibility import summary; from dcrb_ros.recordings.reader import Recording\n"
        "def imported(name):\n"
        "    waveform = WaveformImport(Path(name), Path('about.yaml'))\n"
        "    summary(waveform)\n"
        "    waveform.write(Path('bag'))\n"
        "before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss\n"
        "imported('x.npz') if sys.argv[1] == 'import' else export(Recording('bag'), Path('x.csv'))\n"
        "print(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)"
    )
    for step in dict.fromkeys(("import", command)):
        done = subprocess.run([sys.executable, "-c", code, step], cwd=tmp_path, capture_output=True, text=True, check=True, timeout=400.0)
    assert int(done.stdout) * 1024 < MOST_PER_SAMPLE[command] * samples
