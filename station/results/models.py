"""A model as a file: effects, variants and values, checked when they are read; reading runs no code."""

import math
from functools import lru_cache
from pathlib import Path
from typing import Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from identify.effects.effect import Effect
from identify.effects.families import FAMILY_OF
from identify.effects.library import LIBRARY, NAMED
from identify.effects.sensor_fault import SensorFault
from identify.fitting.fit import Fit
from identify.model.model import Model, Term
from station.exits import UsageProblem
from station.story.pipeline import KnownModel
from station.suggestions import read_named, refusal, shortened


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True)


class Value(_Part):
    """A parameter's value, its standard error (None where the record does not determine it) and its unit."""

    value: float = Field(allow_inf_nan=False)
    std: float | None = Field(default=None, ge=0, allow_inf_nan=False)
    unit: str = Field(default="", max_length=64)


class EffectEntry(_Part):
    """One effect: its name, inner values that are held and the channel at fault, and its parameters."""

    effect: str = Field(max_length=64)
    held: dict[str, float | str] = Field(default_factory=dict)
    parameters: dict[str, Value] = Field(default_factory=dict)


class ModelFile(_Part):
    """A model with its values; `expressions` are effects that the user wrote on the command line."""

    format: Literal[1] = 1
    equation: str = Field(default="", max_length=10_000)
    effects: tuple[EffectEntry, ...] = Field(min_length=1, max_length=40, strict=False)
    expressions: tuple[str, ...] = Field(default=(), max_length=20, strict=False)

    @property
    def names(self) -> list[str]:
        """The effects' names."""
        return [entry.effect for entry in self.effects]

    @property
    def parameters(self) -> dict[str, Value]:
        """All parameters by "effect.parameter"."""
        return {
            f"{entry.effect}.{name}": value
            for entry in self.effects
            for name, value in entry.parameters.items()
        }


def model_file(fit: Fit, expressions: tuple[str, ...] = ()) -> ModelFile:
    """Make the file of a fitted model; `expressions` that it does not use are left out."""
    entries = tuple(
        EffectEntry(
            effect=term.effect.name,
            held=dict(term.held),
            parameters={
                name: Value(
                    value=float(e.value), std=float(e.std) if math.isfinite(e.std) else None, unit=e.unit
                )
                for name, e in fit.of(term, 0).items()
            },
        )
        for term in fit.model.terms
    )
    used = tuple(text for text in expressions if name_of(text) in fit.model)
    return ModelFile(equation=fit.model.equation, effects=entries, expressions=used)


def name_of(expression: str) -> str:
    """Return the name that "magnet = a*u" gives to its effect."""
    return expression.partition("=")[0].strip()


def read_model(file: Path, library: tuple[Effect, ...] = LIBRARY) -> KnownModel:
    """Read and check a model file; UsageProblem that names the file and the entry that is wrong."""
    return known_model(read_model_file(file), f"the model {file}", library)


def read_model_file(file: Path) -> ModelFile:
    """Read a model file as it stands, its effects not looked up yet; UsageProblem as `read_model`."""
    if file.exists() and not file.is_file():  # a pipe would be waited for
        raise UsageProblem(f"the model {file} is no plain file; give the file that refine wrote")
    try:
        return ModelFile.model_validate_json(read_named(file, "the model"))
    except ValidationError as error:
        raise UsageProblem(f"the model {file}: {refusal(error)}") from error


def known_model(model: ModelFile, where: str, library: tuple[Effect, ...] = LIBRARY) -> KnownModel:
    """Return a model with its effects looked up; UsageProblem, beginning with `where`, when one does not fit."""
    try:
        by_name = {e.name: e for e in (*NAMED, *library, *map(parsed_effect, model.expressions))}
    except ValueError as error:
        raise UsageProblem(f"{where}: {shortened(str(error))}") from error
    terms: list[Term] = []
    values: dict[str, float] = {}
    for entry in model.effects:
        effect = by_name.get(entry.effect)
        if effect is None:
            raise UsageProblem(
                f"{where}: no effect is called '{entry.effect}'; see `station effects`, or give the file that "
                "defines it with --effects"
            )
        term = Term(effect, _held(entry, effect, where))
        if any(term.effect.name == other.effect.name for other in terms):
            raise UsageProblem(f"{where}: {entry.effect} stands in it twice")
        terms.append(term)
        values |= _values(entry, term, where)
    return KnownModel(Model(tuple(terms)), values=values, expressions=model.expressions)


@lru_cache(maxsize=64)
def parsed_effect(text: str) -> Effect:
    """Compile the effect that an expression describes, once; ValueError, in a sentence, when it describes none."""
    from identify.effects.user import parse_effect

    effect: Effect = parse_effect(text)
    return effect


def _held(entry: EffectEntry, effect: Effect, where: str) -> dict[str, float | str]:
    places = {name for name, at in entry.held.items() if isinstance(at, float) and at > 0.0}
    if effect in FAMILY_OF and places == entry.held.keys() == effect.variants[0].keys():
        return dict(entry.held)  # the motion at which the strength is stated
    for variant in effect.variants:
        if dict(variant) == entry.held:
            return dict(variant)
    choices = " or ".join(str(dict(variant)) for variant in effect.variants)
    raise UsageProblem(
        f"{where}: {entry.effect}: `held` is {shortened(str(entry.held))}; it can be {choices}"
    )


def _values(entry: EffectEntry, term: Term, where: str) -> dict[str, float]:
    free = {parameter.name: parameter for parameter in term.free}
    unknown = set(entry.parameters) - set(free)
    if unknown:
        raise UsageProblem(
            f"{where}: {entry.effect} has no parameter {shortened(', '.join(sorted(unknown)))}; it has {', '.join(free)}"
        )
    corrected = isinstance(term.effect, SensorFault) and term.effect.corrected_in_every_fit
    missing = set() if corrected else set(free) - set(entry.parameters)
    if missing:
        raise UsageProblem(f"{where}: {entry.effect}: no value for {', '.join(sorted(missing))}")
    values: dict[str, float] = {}
    for name, given in entry.parameters.items():
        low, high = free[name].low, free[name].high
        if not low <= given.value <= high:
            raise UsageProblem(
                f"{where}: {entry.effect}: {name} = {given.value:g} is outside {low:g} to {high:g}"
            )
        values[str(term.parameter(name))] = given.value
    return values
