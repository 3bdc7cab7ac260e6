"""A model fitted to a session, and where it fails."""

from dataclasses import dataclass

from identify.comparison.compare import Comparison
from identify.fitting.baseline import Baseline
from identify.fitting.model_error import ModelError, errors_of, noise_percent
from station.story.residual import residual_words


@dataclass(frozen=True, eq=False)
class Compared:
    """A model as fitted to the session `name`, and where it fails; `words` say which model it is, `remark` why it
    is not another.

    `judged` is the fit by which the model is judged, as everywhere: that of the pieces of a long record, in which the
    phase drifts by more than forces move it; of a short one `baseline` itself, one free run over the whole record.
    """

    name: str
    baseline: Baseline
    comparison: Comparison
    judged: Baseline
    words: str
    remark: str

    @property
    def error(self) -> ModelError:
        """The three errors by which the model is judged."""
        return errors_of(self.judged)

    @property
    def pieces(self) -> int:
        """In how many pieces the record is judged."""
        return len(self.judged.decays)

    @property
    def left(self) -> str:
        """What the model leaves, in words."""
        above = None if self.judged.at_floor else self.error.floor_std
        return residual_words(self.error.motion_percent, self.error.chi_square, above)

    @property
    def one_run(self) -> str:
        """The residual of a long record simulated in one piece, and why it is larger; "" for a short record."""
        if self.pieces < 2:
            return ""
        seen = self.comparison
        return (
            f"The record is long: it is judged in {self.pieces} pieces that share the physics. In one run over "
            f"{seen.horizon_cycles:.0f} cycles the same model leaves {residual_words(seen.motion_error, seen.chi_square)}, "
            "because the phase may drift with clock and temperature. The places and cycles below are those of that run."
        )

    @property
    def motion_floor(self) -> float:
        """The residual of noise alone, in % of the rms of the motion."""
        return noise_percent(self.judged.fit)
