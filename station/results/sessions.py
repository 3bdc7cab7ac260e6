"""Sessions as the operator names them: a folder, or a data file that becomes one on the way."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from glob import escape
from itertools import pairwise
from pathlib import Path

from daq.errors import StorageError
from daq.importing.apply import stated
from daq.importing.errors import ImportProblem
from daq.importing.options import ImportOptions
from daq.importing.propose import Doubtful
from daq.importing.reading import look_at
from daq.importing.recipe import Recipe, to_toml
from daq.manifest import NAME as MANIFEST
from daq.recording import Recording, cut
from daq.sensor_faults import sensor_faults
from daq.session import Session, verify
from daq.session_info import SessionInfo
from daq.session_reading import SOURCE
from identify.errors import NotIdentifiable
from identify.free_decay import FreeDecay
from identify.preprocessing.release import Release, find_releases
from station.exits import UsageProblem
from station.output import command_line, progress
from station.results.kept_recipes import look_with_kept
from station.results.session_names import session_folder
from station.story.free_part import free_from, goes_on
from station.story.preparation import Options, free_decay
from station.suggestions import did_you_mean

MOST_RELEASES = 100
NO_RELEASE = "no release found"
FEWEST_SAMPLES = 32
LONGEST = 100
"""Letters of a name."""


@dataclass(frozen=True, eq=False)
class Imported:
    """The result of an import: the sessions, one for each release, their recordings, and notes on what was guessed."""

    sessions: tuple[Session, ...]
    recordings: tuple[Recording, ...]
    notes: tuple[str, ...]

    @property
    def released(self) -> bool:
        """Whether a release was found in the first session."""
        return not any(note.startswith(NO_RELEASE) for note in self.notes)


def open_session(
    argument: str, sessions: Path, info: SessionInfo | None = None, what: str = "session or data file"
) -> Session:
    """Return the session that the operator means; `what` may be meant is said where it is none.

    `argument` is a session's folder, its name within `sessions` (or its beginning, or `last`: see
    `session_names`), or a data file, which is imported first (a second time it is opened, not imported
    again). Raises UsageProblem when it is none of these.
    """
    path = session_folder(argument, sessions, what)
    known = made_of(path, sessions) if path.is_file() else [path]
    if not known:
        return _import_on_the_way(path, sessions, info or SessionInfo())
    session = Session.open(known[0])
    if words := doubt(session.folder):
        progress(f"warning: {words}")
    return session


def doubt(folder: Path) -> str:
    """Say how the files of a session are not as they were written, and which command tells more; "" where they are."""
    found = verify(folder)
    if found.ok:
        return ""
    wrong, look = "is not sealed: it is still being recorded, or was cut off", "recover"
    if (folder / MANIFEST).exists():
        wrong, look = f"does not agree with its manifest ({found.problems[0]})", "verify"
        wrong += ", so what follows may be wrong"
    return f"{folder.name} {wrong}; see `{command_line(look, folder)}`"


def _import_on_the_way(file: Path, sessions: Path, info: SessionInfo) -> Session:
    try:
        imported = import_file(file, None, sessions, ImportOptions(), info)
    except ImportProblem as error:
        raise explained(error, ("import", file)) from error
    for note in imported.notes:
        progress(f"{file.name}: {note}")
    first, *others = imported.sessions
    progress(f"imported as {first.folder}")
    for session in others:
        progress(f"another release of the file: {session.folder}")
    return first


def explained(refusal: ImportProblem, typed: Sequence[str | Path]) -> UsageProblem | ImportProblem:
    """Return a refusal with the command to type, where a recipe is proposed that would do.

    `typed` are the words of the command that imports the file.
    """
    if not isinstance(refusal, Doubtful):
        return refusal
    proposal = refusal.proposal
    asked = [] if refusal.settled else ["--rate", "HZ"]
    command = command_line(*typed, "--accept", *asked)
    how = "as proposed" if refusal.settled else "as proposed, with its rate in place of HZ"
    said = {"doubts": list(proposal.doubts), "recipe": to_toml(proposal.recipe)}
    where = "These are options of `station import`, and --ask opens the recipe there"
    return UsageProblem(f"{refusal}. {where}. To read it {how}, type: {command}", **said)


def import_file(
    file: Path,
    folder: Path | None,
    sessions: Path,
    options: ImportOptions,
    info: SessionInfo,
    recipe: Recipe | None = None,
    *,
    anew: bool = False,
    kept: Path | None = None,
) -> Imported:
    """Read a file and make a session of each release in it, by a `recipe` where one is given.

    Without options, a recipe that was confirmed for a file of this shape, in the folder of sessions or in `kept`, is used
    again (`kept_recipes`), unless the file is to be read `anew`. The recipe is kept in each session.

    With one release the session is `folder`, or the file's name within `sessions`; where the file holds several runs
    `_run` and the name of the run are added, and a number where one holds several releases. Nothing is overwritten.
    """
    if folder is not None and not folder.name:
        raise UsageProblem(
            "--session names no folder; give the name of a new one, as in --session runs/first"
        )
    if file.is_dir():
        raise UsageProblem(f"{file} is a folder; give a file in it (a shell writes them all as {file}/*)")
    if not file.is_file():
        place = file.parent
        names = sorted(entry.name for entry in place.iterdir()) if place.is_dir() else []
        raise UsageProblem(f"{file}: there is no such file{did_you_mean(file.name, names)}")
    if recipe is None and not anew:
        look, said = look_with_kept(file, kept or sessions, options)
    else:
        look, said = look_at(file, options, recipe), ""
    try:
        read = look.read(accept=options.accept)
    except ImportProblem as refusal:
        raise (
            refusal if not said or isinstance(refusal, Doubtful) else ImportProblem(f"{refusal} ({said})")
        ) from None
    as_said = (recipe is not None or bool(said)) and bool(look.proposal.recipe.parts)
    whole = bool(look.proposal.recipe.parts)
    pieces, notes = _pieces(read.recordings, whole=whole, as_said=as_said)
    run = "all" if options.run == "all" else None  # one run of a file, as its times, says nothing of the next
    told = replace(options, run=run, start=None, stop=None) != ImportOptions()
    confirmed = recipe is not None or told or bool(said) or read.recipe.confirmed
    used = to_toml(read.recipe.model_copy(update={"confirmed": confirmed, "stated": stated(look.table)}))
    first = folder or sessions / _free_name(file, sessions, [name for name, _ in pieces])
    made: list[Session] = []
    for name, part in pieces:
        where = first.with_name(f"{first.name}{name}")
        known = info.model_copy(update={"name": where.name})
        try:
            made.append(Session.create_imported(where, part, file, known, used))
        except StorageError as error:
            left = ", ".join(str(session.folder) for session in made) or "nothing"
            raise type(error)(f"the import failed, and {left} was kept: {error}", error.session) from error
    return Imported(tuple(made), tuple(part for _, part in pieces), (*filter(None, [said]), *notes))


def _pieces(
    runs: Sequence[Recording], *, whole: bool, as_said: bool
) -> tuple[list[tuple[str, Recording]], tuple[str, ...]]:
    """Return the recording of each release with what is added to its session's name, and what was understood; where a recipe
    says the parts, they are taken `as_said`.
    """
    pieces = []
    notes = list(runs[0].notes)
    for run in runs:
        parts, said = ([run], ()) if as_said else split(run, whole=whole)
        name = f"_run{run.run}" if len(runs) > 1 else ""
        for number, part in enumerate(parts, start=1):
            hidden = _smoothed_over(part)
            part = replace(part, notes=(*part.notes, *hidden))
            pieces.append((name if len(parts) == 1 else f"{name}_{number}", part))
            said = (*said, *hidden)
        alike = {_form(note) for note in notes}
        own = [note for note in (*run.notes, *said) if _form(note) not in alike]
        notes += [f"run {run.run}: {note}" if name and run is not runs[0] else note for note in own]
    if len(runs) > 1:
        notes.append(
            f"{len(runs)} runs in the file: each becomes a session; a run without a note of its own was read like the first"
        )
    return pieces, tuple(notes)


def _smoothed_over(recording: Recording) -> tuple[str, ...]:
    """Say which faults of sensors the rows show that a curve through them hides."""
    found = () if recording.as_read is None else sensor_faults(recording.as_read).suspicions
    return tuple(
        f"the rows themselves, before the spline: {one.reason} ({one.advice}); --rate reads them as they are"
        for one in found
    )


def _form(note: str) -> str:
    """Return a note without its numbers."""
    return re.sub(r"[-+]?\d[\d.,]*", "#", note.split(": ", 1)[1] if re.match(r"run \S+: ", note) else note)


def _free_name(file: Path, sessions: Path, names: Sequence[str]) -> str:
    stem = safe_name(
        file.name if file.suffix[1:2].isdigit() else file.stem
    )  # of run_0.900 all: a number is no ending
    name, number = stem, 1
    while (sessions / name).exists() or any((sessions / f"{name}{added}").exists() for added in names):
        number += 1
        name = f"{stem}-{number}"
    return name


def made_of(file: Path, sessions: Path) -> list[Path]:
    """Return the sessions that were made of this very file."""
    content = file.read_bytes()
    copies = sorted(sessions.glob(f"*/{SOURCE}/{escape(file.name)}"))
    return [copy.parents[1] for copy in copies if copy.is_file() and copy.read_bytes() == content]


def safe_name(name: str) -> str:
    """Write a name in letters, digits, dots and dashes, which leads out of no folder; "recording" where none is left."""
    return re.sub(r"[^\w.-]+", "_", name).strip("._")[:LONGEST] or "recording"


def split(recording: Recording, *, whole: bool = False) -> tuple[list[Recording], tuple[str, ...]]:
    """Cut a recording into one for each release; the notes say what was found.

    A push or a drive before a single release is left out, unless the operator chose what to read (`whole`).
    """
    decay = free_decay(recording, Options())
    if decay.driven:
        return [recording], (
            "a force drives the motion to the end: there is no free decay, so the file is one session",
        )
    try:
        releases = find_releases(decay)
    except NotIdentifiable as refusal:
        return [recording], (f"{NO_RELEASE}: {refusal}",)
    if len(releases) < 2:
        return ([recording], ()) if whole else _from_release(recording, decay, releases[0])
    if len(releases) > MOST_RELEASES:
        return [recording], (
            f"{len(releases)} beginnings of a motion found, too many to be releases: the file is one session",
        )
    starts = [0, *(_begin(before, after) for before, after in pairwise(releases))]
    stops = [*starts[1:], recording.samples.shape[1]]
    pieces = [cut(recording, start, stop) for start, stop in zip(starts, stops, strict=True)]
    # Without the hand that pulls the mass again, and without the last, which may be cut off. Driven, half go on by chance.
    motions = [cut(recording, one.index, one.end) for one in releases[:-1]]
    if 3 * sum(goes_on(free_decay(motion, Options())) for motion in motions) > len(motions):
        return [recording], (
            f"{len(releases)} beginnings of a motion found, some of which do not die away, as where it is driven or "
            "beats: the file is one session",
        )
    return pieces, (f"{len(releases)} releases found: each becomes a session",)


def _from_release(
    recording: Recording, decay: FreeDecay, release: Release
) -> tuple[list[Recording], tuple[str, ...]]:
    """Leave out a push or a drive before the decay, where the release itself leaves no sharp mark."""
    found = free_from(decay) if release.kind == "in_motion" and release.index == 0 else None
    if found is None or recording.samples.shape[1] - found[0] < FEWEST_SAMPLES:
        return [recording], ()
    start, what = found
    note = (
        f"{what} was found before the decay: the first {start / recording.rate:.4g} s were left out "
        "(--from and --to, in the times of the file, choose the part to read)"
    )
    return [cut(recording, start, recording.samples.shape[1])], (note,)


def _begin(before: Release, after: Release) -> int:
    """Find where the record of a release begins: with its rest, after the motion before it."""
    if after.rest[1] > after.rest[0]:
        return max(after.rest[0], min(before.end, after.rest[1] - 1))
    return max(before.end, before.index + 1)
