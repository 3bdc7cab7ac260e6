"""Run a notebook in this process and keep what its cells show: `python docs/tools/run_notebook.py docs/tutorial.ipynb`."""

import ast
import base64
import contextlib
import io
import json
import sys
from pathlib import Path
from typing import Any

Json = dict[str, Any]


def executed(notebook: Json, folder: Path) -> Json:
    """Return the notebook with the outputs of every code cell, run in order in `folder`; errors are raised."""
    names: Json = {"__name__": "__main__"}
    cells, count = [], 0
    with contextlib.chdir(folder):
        for cell in notebook["cells"]:
            if cell["cell_type"] == "code":
                count += 1
                cell = cell | {
                    "execution_count": count,
                    "outputs": _outputs("".join(cell["source"]), names, count),
                }
            cells.append(cell)
    return notebook | {"cells": cells}


def _outputs(source: str, names: Json, count: int) -> list[Json]:
    tree = ast.parse(source)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed = io.StringIO()
    shown = None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, "<cell>", "exec"), names)
        if isinstance(last, ast.Expr):
            shown = eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)
    outputs: list[Json] = []
    if printed.getvalue():
        outputs.append({"output_type": "stream", "name": "stdout", "text": _lines(printed.getvalue())})
    if shown is not None:
        outputs.append(
            {"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": _data(shown)}
        )
    return outputs


def _data(shown: Any) -> Json:
    if hasattr(shown, "_repr_png_"):
        return {"image/png": base64.b64encode(shown._repr_png_()).decode(), "text/plain": ["a picture"]}
    data = {"text/plain": _lines(repr(shown))}
    return data | {"text/html": _lines(shown._repr_html_())} if hasattr(shown, "_repr_html_") else data


def _lines(text: str) -> list[str]:
    return text.splitlines(keepends=True)


def main(file: Path) -> None:
    """Run a notebook and write it back with its outputs."""
    notebook = executed(json.loads(file.read_text(encoding="utf-8")), file.parent)
    file.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
