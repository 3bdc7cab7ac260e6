"""What effects are called: one name for people, "Stribeck friction"; one for programs, `stribeck_friction`."""

_PROPER = {"coulomb": "Coulomb", "stribeck": "Stribeck", "maxwell": "Maxwell", "dahl": "Dahl", "lugre": "LuGre",
           "bouc": "Bouc", "wen": "Wen", "ac": "AC"}  # fmt: skip


def plain_name(name: str) -> str:
    """Return the name for people of an effect: that for programs with blanks, names of persons with capitals."""
    return " ".join(_PROPER.get(word, word) for word in name.split("_"))
