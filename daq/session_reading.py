"""One session's folder as it is read: metadata, raw log, recording, manifest, results. Reading takes no lock."""

from dataclasses import replace
from pathlib import Path
from typing import Self

from pydantic import ValidationError

from daq.decode import Assembly, assemble
from daq.errors import DataLost, NotASession, SessionDamaged, StorageError
from daq.manifest import Manifest, is_plain_name, known_manifest, read_manifest
from daq.plain_text import first_fault
from daq.quality import Verdict
from daq.raw_log import Record, read
from daq.recording import Channel, Recording
from daq.session_info import SensorInfo, SessionInfo
from daq.storage import read_regular

INFO = "session.json"
RAW = "raw.log"
RESULTS = "results"
SOURCE = "source"
RECIPE = "recipe.toml"
MAX_INFO = 1 << 20


class SessionReader:
    """What a session's folder holds, read when it is asked for."""

    def __init__(self, folder: Path, info: SessionInfo) -> None:
        self.folder = folder
        self.info = info

    @classmethod
    def open(cls, folder: Path | str) -> Self:
        """Open a session for reading; NotASession or SessionDamaged when it is none."""
        folder = Path(folder)
        return cls(folder, read_info(folder))

    @property
    def results(self) -> Path:
        """The folder of results; it is there."""
        return self.folder / RESULTS

    @property
    def source_file(self) -> Path | None:
        """The copy of the imported file, or None."""
        name = self.info.source_file
        return self.folder / SOURCE / name if name and is_plain_name(name) else None

    def records(self) -> tuple[Record, ...]:
        """The records of the raw log, in order."""
        return read(self.folder / RAW).records

    def assembly(self) -> Assembly:
        """Decode the raw log; what is damaged in it is listed in the notes."""
        raw = read(self.folder / RAW)
        assembly = assemble(raw.records)
        if raw.damaged:
            assembly.notes.append(f"{raw.damaged} damaged pieces of the raw log were skipped")
        return assembly

    def recording(self) -> Recording:
        """Return the recording, decoded from the raw bytes; DataLost when they hold no sample or are gone."""
        try:
            return self.complete(self.assembly().recording())
        except NotASession as error:
            raise DataLost(self._without_raw("is missing"), self.folder) from error
        except DataLost as error:
            known, raw = known_manifest(self.folder), self.folder / RAW
            if known is not None and RAW in known.files and known.files[RAW].size > raw.stat().st_size:
                words = self._without_raw("is shorter than when it was written")
                raise DataLost(words, self.folder) from error
            raise DataLost(f"{self.folder}: {error}", self.folder) from error

    def _without_raw(self, how: str) -> str:
        """Say how the raw log was damaged, and what to do."""
        source = self.source_file
        todo = "put it back from a copy, or record again"
        if source is not None and source.is_file():
            todo = f"import {source.parent.name}/{source.name} in the folder of the session again"
        return f"{RAW}, which holds the samples of {self.folder.name}, {how}: {todo}"

    def complete(self, recording: Recording) -> Recording:
        """Add what the metadata know: calibrations and the uncertainty of the rate."""
        known = {sensor.channel: sensor for sensor in self.info.sensors}
        channels = tuple(_calibrated(channel, known.get(channel.name)) for channel in recording.channels)
        return replace(recording, channels=channels, rate_std=self.info.rate_std_hz)

    @property
    def verdict(self) -> Verdict | None:
        """The verdict of the manifest; None when the session is not sealed."""
        known = known_manifest(self.folder)
        return known.verdict if known is not None else None

    def manifest(self) -> Manifest:
        """Read the manifest; NotASession when the session is not sealed, SessionDamaged when altered."""
        return read_manifest(self.folder)

    def read_result(self, name: str, limit: int) -> bytes | None:
        """Return `results/name`, None when there is none; StorageError when it is a link, or longer than `limit`."""
        if self.results.is_symlink():
            raise StorageError(f"{self.results} is a link to elsewhere; remove it, nothing was read")
        try:
            return read_regular(self.results / name, limit)
        except NotASession:
            return None


def read_info(folder: Path) -> SessionInfo:
    """Read and check `session.json`."""
    try:
        data = read_regular(folder / INFO, MAX_INFO)
    except NotASession as error:
        raise NotASession(f"{folder} is no session: there is no {INFO} in it") from error
    try:
        return SessionInfo.model_validate_json(data)
    except ValidationError as error:
        raise SessionDamaged(f"{folder / INFO}: {first_fault(error)}; recover the session") from error


def _calibrated(channel: Channel, sensor: SensorInfo | None) -> Channel:
    if sensor is None:
        return channel
    uncertainty = channel.calibration_uncertainty if sensor.uncertainty is None else sensor.uncertainty
    return replace(channel, sensor=channel.sensor or sensor.sensor, calibration_uncertainty=uncertainty)
