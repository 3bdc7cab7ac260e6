"""Every sentence that the program can say: the string literals of its source but for docstrings, f-strings with gaps."""

import ast
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGES = ("station", "identify", "daq", "mocks", "firmware_protocol")
GAP = "{}"
FEWEST_WORDS = 3


@dataclass(frozen=True)
class Sentence:
    """One literal: where it stands, and its text with `{}` where something is put in."""

    file: str
    line: int
    text: str


def sentences() -> list[Sentence]:
    """Return all literals of three words or more, file by file."""
    found = []
    for package in PACKAGES:
        for file in sorted((ROOT / package).rglob("*.py")):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            docstrings = _docstrings(tree)
            inside = {id(part) for node in ast.walk(tree) if isinstance(node, ast.JoinedStr) for part in ast.walk(node)
                      if part is not node and isinstance(part, ast.Constant)}  # fmt: skip
            for node in ast.walk(tree):
                text = _text(node)
                if text is None or id(node) in inside or id(node) in docstrings:
                    continue
                if len(text.split()) >= FEWEST_WORDS:
                    found.append(Sentence(str(file.relative_to(ROOT)), node.lineno, text))
    return found


def _text(node: ast.AST) -> str | None:
    if isinstance(node, ast.Constant) and isinstance(node.value, str):
        return node.value
    if isinstance(node, ast.JoinedStr):
        return "".join(part.value if isinstance(part, ast.Constant) else GAP for part in node.values)
    return None


def _docstrings(tree: ast.AST) -> set[int]:
    """Return the literals that stand as statements of their own: docstrings, of functions and of constants."""
    return {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
