"""A model with what is known of it: its name in words, and the values to fit it from."""

from dataclasses import dataclass, field

from identify.fitting.initial_values import initial_values
from identify.model.model import Model
from identify.preprocessing.prepared_decay import PreparedDecay


@dataclass(frozen=True, eq=False)
class KnownModel:
    """A model, with its name in `words`; `remark` says why it is not another that one might expect.

    `values` are those to fit from, by "effect.parameter" (none: from the data), `expressions` the operator's own effects.
    """

    model: Model
    words: str = "the usual model"
    values: dict[str, float] = field(default_factory=dict)
    expressions: tuple[str, ...] = ()
    remark: str = ""

    def start(self, decays: tuple[PreparedDecay, ...]) -> dict[str, float] | None:
        """Find where a fit to some releases begins, by unknown's name: these values, the releases' own from their motions.

        None where the data say all.
        """
        if not self.values:
            return None
        start = initial_values(decays, self.model, self.values)
        for term in self.model.terms:
            for parameter in term.free:
                id = term.parameter(parameter.name)
                if str(id) not in self.values:
                    continue
                for i in range(1 if term.is_force else len(decays)):
                    own = id if term.is_force else id.of_release(i, len(decays))
                    start[str(own)] = self.values[str(id)]
        return start
