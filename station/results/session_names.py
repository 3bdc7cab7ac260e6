"""A session's name as it is typed: in full, by any beginning that only one session has, or `last`."""

from pathlib import Path

from daq.session import list_sessions
from station.exits import UsageProblem
from station.suggestions import did_you_mean

LAST = "last"
MOST_LISTED = 5
WORD_ENDS = "_-."


def find_session(name: str, sessions: Path) -> Path | None:
    """Return the folder that `name` means among those in `sessions`; None when nothing there is called so.

    A name in full comes before a beginning, and a beginning that ends where a word does before one that does
    not: `mystery_7` is `mystery_7_20260101_120000` though `mystery_70_20260101_120500` begins so too. `last`
    is the session that was made last. Raises UsageProblem when several sessions begin with `name`.
    """
    if (sessions / name).is_dir():
        return sessions / name
    if not name or not sessions.is_dir():
        return None
    folders = [summary.folder for summary in list_sessions(sessions)]
    if name == LAST:
        return folders[-1] if folders else None
    found = [folder for folder in folders if folder.name.startswith(name)]
    whole = [folder for folder in found if folder.name[len(name)] in WORD_ENDS]
    candidates = whole or found
    if len(candidates) > 1:
        newest = [folder.name for folder in reversed(candidates)][:MOST_LISTED]
        more = len(candidates) - len(newest)
        names = ", ".join(newest) + (f" and {more} more" if more else "")
        raise UsageProblem(
            f"{name}: {len(candidates)} sessions begin so: {names}; type more of the name, or `{LAST}`"
        )
    return candidates[0] if candidates else None


def session_folder(argument: str, sessions: Path, what: str = "session") -> Path:
    """Return the folder of a session given by its path or its name; UsageProblem when there is none.

    Where `what` is meant may be a file, the path of one is returned.
    """
    path = Path(argument)
    if path.is_dir() or ("file" in what and path.is_file()):
        return path
    found = find_session(argument, sessions)
    if found is None:
        raise _no_such(argument, sessions, what)
    return found


def _no_such(argument: str, sessions: Path, what: str) -> UsageProblem:
    """Return the refusal of a session that is not there, with the names that are nearest to it."""
    path = Path(argument)
    place = sessions if len(path.parts) < 2 else path.parent
    names = sorted(entry.name for entry in place.iterdir()) if place.is_dir() else []
    beside = [entry.name for entry in Path().iterdir()] if len(path.parts) < 2 and "file" in what else []
    meant = did_you_mean(path.name, [*names, *sorted(beside)])
    if not names and not meant and place == sessions:
        meant = "; there are none yet: `station demo` and `station import FILE` make one"
    return UsageProblem(
        f"{argument}: there is no such {what} (sessions are looked for in {place.resolve()}){meant}"
    )
