"""A notebook as a page: its text, its code and its outputs, as they were saved; nothing is run."""

import base64
import json
from typing import Any

PICTURES = {"image/png": "png", "image/jpeg": "jpg", "image/svg+xml": "svg"}


def page_of_notebook(text: str, name: str) -> tuple[str, dict[str, bytes]]:
    """Return a notebook as Markdown, and its pictures by their place on the site."""
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in json.loads(text)["cells"]:
        source = "".join(cell["source"]).strip()
        if cell["cell_type"] == "markdown":
            parts.append(source)
        elif cell["cell_type"] == "code" and source:
            parts.append(f"```python\n{source}\n```")
            for output in cell["outputs"]:
                parts.extend(_shown(output, name, pictures))
    return "\n\n".join(parts) + "\n", pictures


def _shown(output: dict[str, Any], name: str, pictures: dict[str, bytes]) -> list[str]:
    """Return what a cell has shown, the richest form that a page can hold."""
    if output["output_type"] == "stream":
        return [f"```text\n{''.join(output['text']).rstrip()}\n```"]
    data = output.get("data", {})
    for kind, ending in PICTURES.items():
        if kind in data:
            content = "".join(data[kind])
            place = f"{name}_{len(pictures)}.{ending}"
            pictures[place] = content.encode() if ending == "svg" else base64.b64decode(content)
            return [f"![]({place})"]
    if "text/html" in data:
        return [f'<div class="output">\n{"".join(data["text/html"]).strip()}\n</div>']
    if "text/plain" in data:
        return [f"```text\n{''.join(data['text/plain']).rstrip()}\n```"]
    return []
