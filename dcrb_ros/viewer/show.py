"""The functions of `dcrb view`: check the output paths, read the recording, write a Rerun file or picture, or open the viewer."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dcrb_ros.recordings.reader import Recording
from dcrb_ros.recordings.recovery import plain_files
from dcrb_ros.recordings.vehicle_folder import vehicle_boxes
from dcrb_ros.schema.refusal import Refusal
from dcrb_ros.text.files import checked_path
from dcrb_ros.text.temporary import temporary
from dcrb_ros.text.writing import whole_file
from dcrb_ros.viewer.content import Content
from dcrb_ros.viewer.reader import read_content

if TYPE_CHECKING:
    from dcrb_ros.recordings.vehicle import VehicleRecording
    from dcrb_ros.viewer.vehicle_content import VehicleContent


def checked_output(path: Path, *, suffix: str, option: str) -> Path:
    """Return the path of a new file.

    Raises:
        Refusal: it has another suffix than ``suffix``, exists, or cannot be created.
    """
    if path.suffix != suffix:
        raise Refusal(f"{option} {path} does not end in {suffix}: give a name with this suffix")
    if checked_path(path).exists():
        raise Refusal(f"{option} {path} exists: give another name or remove it")
    folder = path.absolute().parent
    if not folder.is_dir():
        raise Refusal(f"{option} {path} cannot be written: there is no folder {folder}; create it or give another path")
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise Refusal(f"{option} {path} cannot be written: {error.strerror}; give another folder") from None
    return path


def write(content: Content | VehicleContent, path: Path, *, native: tuple[Path, ...] = (), picture_only: bool = False) -> None:
    """Write a bench or a vehicle to a Rerun file, with the other topics of the MCAP files ``native``."""
    # Rerun takes a second to import; meanwhile the fault detector already runs in the background.
    if isinstance(content, Content):
        from dcrb_ros.viewer.document import write_document

        write_document(content, path, native=native, picture_only=picture_only)
    else:
        from dcrb_ros.viewer.vehicle_document import write_vehicle_document

        write_vehicle_document(content, path, native=native, picture_only=picture_only)


def save_document(recording: Recording | VehicleRecording, content: Content | VehicleContent, path: Path) -> None:
    """Write the Rerun file, with the recording's other topics; an incomplete file is never left behind.

    Raises:
        Refusal: the file cannot be written.
    """
    with whole_file(path) as part, temporary(path.absolute().parent) as folder:
        write(content, part, native=plain_files(recording.stored, folder, complete=not recording.damage))


def take_picture(content: Content | VehicleContent, path: Path) -> None:
    """Write a PNG of the viewer at `screenshot_time`."""
    from dcrb_ros.viewer.window import save_screenshot

    with tempfile.TemporaryDirectory(prefix="dcrb-view-") as folder:
        document = Path(folder, "picture.rrd")
        write(content, document, picture_only=True)
        save_screenshot(document, path, at_ns=screenshot_time(content))


def show(recording: Recording | VehicleRecording, content: Content | VehicleContent, *, web: bool = False) -> int:
    """Open the viewer with the recording; return its exit status after it is closed."""
    from dcrb_ros.viewer.window import open_window

    with tempfile.TemporaryDirectory(prefix="dcrb-view-") as folder:
        document = Path(folder, f"{content.title}.rrd")
        save_document(recording, content, document)
        return open_window(document, web=web)


def screenshot_time(content: Content | VehicleContent) -> int:
    """Return the time of the largest roller force in the last third of the recording, when spectra and verdicts are available [ns].

    Of a vehicle, it is `dcrb_ros.viewer.vehicle_document.picture_time`.
    """
    if not isinstance(content, Content):
        from dcrb_ros.viewer.vehicle_document import picture_time

        return picture_time(content)
    begin = content.start_ns + 2 * (content.end_ns - content.start_ns) // 3
    if content.motion is None:
        return begin
    rollers = content.bodies.rows * content.bodies.rollers_per_row
    late = np.flatnonzero((content.motion.time_ns >= begin) & (content.motion.time_ns <= content.end_ns))
    if not len(late):
        return begin
    return int(content.motion.time_ns[late[np.argmax(content.motion.force[late, :rollers].max(axis=1))]])


def view_recording(bag: Path, *, save: Path | None, screenshot: Path | None, web: bool) -> tuple[Content | VehicleContent, bool, int]:
    """Write the requested files, which the caller has checked, or open the viewer.

    Returns the content, whether the recording is complete, and the exit status of the viewer.

    Raises:
        Refusal: the recording is invalid.
    """
    content: Content | VehicleContent
    recording: Recording | VehicleRecording
    if vehicle_boxes(bag):
        from dcrb_ros.recordings.vehicle import VehicleRecording
        from dcrb_ros.viewer.vehicle_content import read_vehicle_content

        recording = VehicleRecording(bag)
        content = read_vehicle_content(recording)
    else:
        recording = Recording(bag)
        content = read_content(recording)
    if save is not None:
        save_document(recording, content, save)
    if screenshot is not None:
        take_picture(content, screenshot)
    status = show(recording, content, web=web) if save is None and screenshot is None else 0
    return content, not recording.damage, status
