"""The import contracts of pyproject.toml: which rooms and modules lie in which layer of which package."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

Layers = tuple[tuple[str, ...], ...]


def layers_by_package(text: str) -> dict[str, Layers]:
    """Return the layers of each package, the highest first; "" has the packages themselves."""
    found: dict[str, Layers] = {}
    for contract in tomllib.loads(text)["tool"]["importlinter"]["contracts"]:
        if contract["type"] == "layers":
            for package in contract.get("containers", [""]):
                found[package] = tuple(split_layer(layer) for layer in contract["layers"])
    return found


def split_layer(layer: str) -> tuple[str, ...]:
    """Return the members of a layer."""
    return tuple(part.strip() for part in layer.replace("|", ":").split(":"))


def contracts() -> dict[str, Layers]:
    return layers_by_package((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
