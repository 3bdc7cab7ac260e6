"""Exit codes: how a command ended, for the shell and for scripts."""

import traceback

DONE = 0
UNEXPECTED = 1
USAGE = 2
NO_BOARD = 3
PROTOCOL = 4
LOST_DATA = 5
DISCONNECTED = 6
STORAGE = 7
NOT_IDENTIFIABLE = 8
CONFLICT = 9
ELSEWHERE = 10
INTERRUPTED = 130

MEANING = {
    DONE: "done",
    UNEXPECTED: "unexpected: a fault of the program",
    USAGE: "wrong usage, settings or file",
    NO_BOARD: "no board, or the port is busy",
    PROTOCOL: "the board refuses, or speaks another protocol or version",
    LOST_DATA: "more data were lost than the limit allows",
    DISCONNECTED: "the board was disconnected or stalled",
    STORAGE: "the disk refused: full, read-only or damaged",
    NOT_IDENTIFIABLE: "the record does not allow an identification",
    CONFLICT: "another program writes the session, or changed it meanwhile; nothing was written",
    ELSEWHERE: "done, but the disk refused and the session lies in a temporary folder",
    INTERRUPTED: "interrupted by the operator",
}


class Problem(Exception):
    """A failure with a sentence for the operator: what happened, what was kept, what to do."""

    exit_code = UNEXPECTED


class UsageProblem(Problem):
    """The operator asked for something that cannot be done so; `details` stand beside the sentence in JSON."""

    exit_code = USAGE

    def __init__(self, sentence: str, **details: object) -> None:
        super().__init__(sentence)
        self.details = details


class Answered(Problem):
    """A refusal whose answer is printed already, as JSON where that was asked for."""

    reported = True

    def __init__(self, sentence: str, exit_code: int = NOT_IDENTIFIABLE) -> None:
        super().__init__(sentence)
        self.exit_code = exit_code


def sentence_of(error: BaseException, advice: str = "") -> str:
    """Write an error as a sentence in one line; a fault of the program with its place and what to do."""
    text = " ".join(str(error).split()) or type(error).__name__
    if code_of(error) != UNEXPECTED or isinstance(error, Problem):
        return text
    place = traceback.extract_tb(error.__traceback__)[-1]
    what = f"{type(error).__name__}: {' '.join(str(error).split())}; {place.name}, line {place.lineno}"
    return f"a fault of this program ({what}); nothing recorded is lost{advice}"


def code_of(error: BaseException) -> int:
    """Return the exit code of an error, by whose fault it is.

    The errors of the acquisition carry their own `exit_code`; an identification that is not possible is 8,
    the disk's OSErrors are 7.
    """
    carried = getattr(error, "exit_code", None)
    if isinstance(carried, int):
        return carried
    if type(error).__name__ == "NotIdentifiable":  # named, not imported: that would import numpy at start-up
        return NOT_IDENTIFIABLE
    if isinstance(error, OSError):
        return STORAGE
    return UNEXPECTED
