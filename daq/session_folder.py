"""One session's folder: created, filled, sealed, changed; the layout is drawn in `session`."""

from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError

from daq.clock_check import checked_rate
from daq.decode import IMPORT, Assembly
from daq.errors import DataLost, OperatorError, SessionChanged, StorageError
from daq.import_log import import_log
from daq.manifest import (
    Counts,
    FileEntry,
    Manifest,
    commit,
    complete,
    entry,
    is_plain_name,
    known_manifest,
    session_files,
)
from daq.plain_text import first_fault
from daq.quality import Grade, Verdict, judge
from daq.raw_log import MAX_LOG, RawLog
from daq.recording import Recording
from daq.sensor_faults import sensor_faults
from daq.session_info import SensorInfo, SessionInfo, State
from daq.session_reading import INFO, RAW, RECIPE, RESULTS, SOURCE, SessionReader, read_info
from daq.storage import (
    WAIT_S,
    Lock,
    digest,
    discard,
    make_folder,
    read_regular,
    refused,
    require_empty,
    stored_name,
    write_whole,
)


class Session(SessionReader):
    """One session's folder. Reading takes no lock; a change holds one, and a capture from the raw log until it seals.

    `completed` are the files whose change a killed program had left half-way, and which `recover` completed.
    """

    def __init__(
        self, folder: Path, info: SessionInfo, lock: Lock | None = None, completed: tuple[str, ...] = ()
    ) -> None:
        super().__init__(folder, info)
        self.completed = completed
        self._lock = lock

    @classmethod
    def create(cls, folder: Path | str, info: SessionInfo, log: RawLog) -> Self:
        """Make a new folder, lock it and let `log` write into it from its first record on.

        OperatorError when the folder holds something, StorageError when the disk refuses.
        """
        folder = Path(folder)
        name = stored_name(info.name or folder.name)
        lock = Lock(folder)
        session = cls(folder, info.model_copy(update={"name": name}), lock)
        make_folder(folder)
        with ExitStack() as undo:
            undo.callback(session._give_back)
            lock.acquire()
            require_empty(folder)  # another process may have made a session here in between
            undo.callback(discard, folder)
            log.note(event="session", info=session.info.model_dump(mode="json"))
            make_inner(session.results)
            write_whole(folder / INFO, _to_bytes(session.info))
            log.store(folder / RAW)
            undo.pop_all()
        return session

    @classmethod
    def create_imported(
        cls,
        folder: Path | str,
        recording: Recording,
        source: Path | None,
        info: SessionInfo | None = None,
        recipe: str = "",
    ) -> Self:
        """Make a sealed session of a recording from elsewhere; samples are kept bit by bit as DATA frames.

        `source` is the file it came from, `recipe` how it was read; both are kept. Errors as in `create`; OperatorError when
        the recording has more channels than one message describes.
        """
        info = info or SessionInfo()
        content = read_regular(source, MAX_LOG) if source is not None else b""
        log = import_log(recording)
        sensors = tuple(
            SensorInfo(channel=c.name[:255], sensor=c.sensor[:255], uncertainty=c.calibration_uncertainty)
            for c in recording.channels
        )
        changes: dict[str, Any] = {
            "state": State.RECORDING,
            "sensors": info.sensors or sensors,
            "source": info.source or (str(source).encode(errors="replace").decode() if source else ""),
            "source_file": stored_name(source.name) if source else "",
            "rate_hz": recording.rate,
            "rate_std_hz": recording.rate_std,
        }
        session = cls.create(folder, info.model_copy(update=changes), log)
        with ExitStack() as undo:  # the file is there to be imported again
            undo.callback(session._give_back)
            undo.callback(discard, session.folder)
            if source is not None:
                make_inner(session.folder / SOURCE)
                write_whole(session.folder / SOURCE / stored_name(source.name), content)
            if recipe:
                write_whole(session.folder / RECIPE, recipe.encode(errors="replace"))
            log.close()
            if log.failure is not None:
                raise log.failure
            session.seal()
            undo.pop_all()
        return session

    def require_writable(self) -> None:
        """NotWritable where nothing may be written into the session, SessionLocked as in `write_results`."""
        with self._writing():
            pass

    def update(self, **changes: Any) -> None:
        """Change metadata; OperatorError when a value is out of range, SessionLocked as in `write_results`."""
        with self._writing() as begun:
            known = self.info if begun else read_info(self.folder)
            try:
                self.info = SessionInfo.model_validate({**known.model_dump(), **changes})
            except ValidationError as error:
                raise OperatorError(first_fault(error)) from error
            self._change({INFO: _to_bytes(self.info)})

    def write_result(self, name: str, data: str | bytes) -> Path:
        """Write one result as `write_results` does, and return its file."""
        self.write_results({name: data})
        return self.results / name

    def write_results(
        self, contents: Mapping[str, str | bytes], seen: Mapping[str, str | None] | None = None
    ) -> None:
        """Write files of `results` and their checksums in the manifest as one change; what is there is overwritten.

        `seen` holds, for results on which the change is based, the checksum of what was read (`daq.storage.digest`;
        None for no file). SessionChanged when one is another by now, SessionLocked when another process does not end
        its own change in time; nothing is written then.
        """
        for name in contents:
            if not is_plain_name(name) or "/" in name or "\\" in name:
                raise OperatorError(f"{name!r} is no name for a result; use letters, digits, dots and dashes")
        plain = {
            f"{RESULTS}/{name}": data.encode() if isinstance(data, str) else data
            for name, data in contents.items()
        }
        with self._writing():
            for name, checksum in (seen or {}).items():
                there = self.read_result(name, MAX_LOG)
                if (None if there is None else digest(there)) != checksum:
                    raise SessionChanged(
                        f"{self.folder.name}: another program has changed {RESULTS}/{name} meanwhile; nothing was"
                        " written, look at it and do this step again"
                    )
            make_inner(self.results)
            self._change(plain)

    def seal(
        self,
        state: State = State.SEALED,
        reason: str = "",
        resent: int = 0,
        damaged_frames: int = 0,
        check_clock: bool = True,
    ) -> None:
        """Judge the recording, write metadata and manifest, and give the lock back."""
        with self._writing():
            known = known_manifest(self.folder)
            assembly = self.assembly()
            wire = Counts(
                planned=self.info.planned_samples or 0, resent=resent, damaged_frames=damaged_frames
            )
            judged = _judged(self.info, assembly, check_clock, wire)
            verdict = judged["verdict"].grade.value
            changes: dict[str, Any] = {"state": state, "reason": reason[:2000], "verdict": verdict}
            if assembly.origin != IMPORT:
                changes["rate_std_hz"] = checked_rate(assembly, check_clock).std or None
            self.info = self.info.model_copy(update=changes)
            files = self._entries(known.files if known else {})
            sealed = Manifest(state=state, files=files, **judged)
            changed = {INFO: _to_bytes(self.info)}
            commit(self.folder, changed, sealed.with_files(changed))
            self.release()

    def release(self) -> None:
        """Give the lock back; harmless when it is not held."""
        if self._lock is not None:
            self._lock.release()
            self._lock = None

    def _give_back(self) -> None:
        """Give the lock back and remove the folder, in which nothing is."""
        self.release()
        with suppress(OSError):
            self.folder.rmdir()

    def _entries(self, known: dict[str, FileEntry]) -> dict[str, FileEntry]:
        """Checksums of all files; the raw log's and the source's, once known, are never made again."""
        files = {}
        for name in session_files(self.folder):
            keep = name in known and (name == RAW or name.startswith(f"{SOURCE}/"))
            files[name] = known[name] if keep else entry(read_regular(self.folder / name, MAX_LOG))
        return files

    @contextmanager
    def _writing(self) -> Iterator[bool]:
        """Hold the lock; whether it was held before is given. A change that was cut off is completed first."""
        if self._lock is not None:
            yield True
            return
        lock = Lock(self.folder, WAIT_S)
        lock.acquire()
        self._lock = lock
        try:
            complete(self.folder)
            yield False
        finally:
            self.release()

    def _change(self, contents: Mapping[str, bytes]) -> None:
        known = known_manifest(self.folder)
        if known is not None:
            commit(self.folder, contents, known.with_files(contents))
            return
        for name, data in contents.items():
            write_whole(self.folder / name, data)


def _to_bytes(info: SessionInfo) -> bytes:
    return info.model_dump_json(indent=1).encode() + b"\n"


def _judged(info: SessionInfo, assembly: Assembly, check_clock: bool, wire: Counts) -> dict[str, Any]:
    """Return verdict, counts (those of the wire completed), gaps and flags of a session's recording for the manifest."""
    try:
        recording = assembly.recording()
    except DataLost:
        return {"verdict": Verdict(grade=Grade.REJECT, reasons=("no sample was received",)), "counts": wire}
    sensors = sensor_faults(recording, assembly)
    verdict = judge(recording, assembly, info.planned_samples, info.noise, check_clock, sensors)
    counts = {
        "samples": len(recording.valid),
        "lost": int(len(recording.valid) - recording.valid.sum()),
        "frames": assembly.frames,
        "duplicates": assembly.samples.duplicates,
    }
    whole = wire.model_copy(update=counts)
    return {"verdict": verdict, "counts": whole, "gaps": recording.gaps, "flags": sensors.runs}


def make_inner(folder: Path) -> None:
    """Make a folder within a session, if it is not there; StorageError for a link to elsewhere."""
    if folder.is_symlink():
        raise StorageError(f"{folder} is a link to elsewhere; remove it, nothing was written")
    try:
        folder.mkdir(exist_ok=True)
    except OSError as error:
        raise refused(folder, error) from error
