"""The pages of the API reference: one for each room, with every module in it, from the folders as they are."""

import ast
from pathlib import Path

PACKAGES = ("identify", "daq", "firmware_protocol")
"""The packages that a program may call; `station` is a program, `mocks` a test bench."""


def reference_pages(root: Path) -> dict[str, str]:
    """Return the text of each page by its place on the site: a package's own modules, then each of its rooms."""
    pages = {}
    for package in PACKAGES:
        rooms = [
            folder for folder in sorted((root / package).iterdir()) if (folder / "__init__.py").is_file()
        ]
        own = [module for module in modules(root / package) if module not in ("__init__", "__main__")]
        links = "".join(
            f"- [`{package}.{room.name}`]({package}/{room.name}.md): {idea(room)}\n" for room in rooms
        )
        pages[f"reference/{package}.md"] = (
            f"# {package}\n\n{docstring(root / package)}\n\n{face(root / package)}{links}\n{sections(package, own)}"
        )
        for room in rooms:
            name = f"{package}.{room.name}"
            below = [f"{inner.name}.{module}" for inner in sorted(room.iterdir()) if (inner / "__init__.py").is_file()
                     for module in modules(inner)]  # fmt: skip
            text = sections(name, [m for m in (*modules(room), *below) if not m.endswith("__init__")])
            pages[f"reference/{package}/{room.name}.md"] = f"# {name}\n\n{idea(room)}\n\n{text}"
    return pages


def modules(folder: Path) -> list[str]:
    """Return the names of the modules of a package that are not private."""
    return sorted(path.stem for path in folder.glob("*.py") if path.stem == "__init__" or path.stem[0] != "_")


def docstring(folder: Path) -> str:
    """Return what a package says of itself."""
    return ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""


def idea(folder: Path) -> str:
    """Return the first line of a package's docstring."""
    return docstring(folder).partition("\n")[0]


def face(folder: Path) -> str:
    """Return a list of the names that a package offers itself, each with a link to where it is described.

    They are those that `__init__` imports from its own modules, at once or for the type checker only.
    """
    package, lines = folder.name, []
    for node in ast.walk(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}."):
            module = folder.parent / f"{(node.module or '').replace('.', '/')}.py"
            described = documented(module)
            lines += [
                f"- [`{package}.{alias.name}`][{node.module}.{alias.name}]: {described[alias.name]}\n"
                for alias in node.names
                if alias.name in described
            ]
    return "".join(["## What it offers\n\n", *sorted(lines), "\n"]) if lines else ""


def documented(module: Path) -> dict[str, str]:
    """Return the classes and functions of a module that say what they are, with the first paragraph of it."""
    if not module.is_file():
        return {}
    kinds = (ast.ClassDef, ast.FunctionDef)
    body = ast.parse(module.read_text(encoding="utf-8")).body
    said = {node.name: ast.get_docstring(node) for node in body if isinstance(node, kinds)}
    return {name: " ".join(text.partition("\n\n")[0].split()) for name, text in said.items() if text}


def sections(package: str, names: list[str]) -> str:
    """Return the Markdown that mkdocstrings turns into the reference of some modules."""
    return "\n".join(f"::: {package}.{name}\n" for name in names)
