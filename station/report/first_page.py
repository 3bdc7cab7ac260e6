"""The first page, for a customer: what was measured, one verdict, a picture, and values with the whole of their error."""

from datetime import UTC

from identify.fitting.fit import Fit
from identify.formatting import DASH, among, decimals_for, plain_name, three_figures, with_error
from identify.residual import residual_words
from station.report.findings import Findings
from station.story.adequacy import judgement, scale_doubt
from station.story.engineering_values import budget, engineering_values
from station.story.preparation import calibration_of
from station.text.content import Figure, Paragraph, Part, Table, Told, facts
from station.text.diagnosis_text import verdict_line
from station.text.identification_text import mass_words
from station.text.layout import sentence
from station.text.numbers import typeset_unit
from station.views.comparison_figures import front

_NOISE = "so only noise remains"
NOT_STATED, UNKNOWN = "not stated", "not determined"
COVERS = (
    "Every error is one standard uncertainty. The error beside a value covers readings and clock. Calibration comes from "
    "the sensors' certificates, the mass from the operator. The total combines all of them (GUM); it is not determined "
    "where one that enters the value was not stated."
)


def first_page(found: Findings) -> Told:
    """Put the first page together: the verdict, in brief what was measured, and the parts of the result."""
    fit, verdict = _explaining(found) or (None, sentence(_nothing_explains(found)))
    parts: list[Part] = []
    if found.compared is not None:
        caption = (
            "Measurement and model, run freely from the release; below, the residual and the noise (2 std.)."
        )
        if found.first is not None:
            caption = f"{caption[:-1]}, before ({found.first.words}) and after ({found.compared.words}); the scales differ."
        shown = [(c.words, c.baseline.fit) for c in (found.first, found.compared) if c is not None]
        parts.append(Figure(caption, front(shown)))
    if fit is not None:
        parts += [_values(fit, found), Paragraph(COVERS)]
        aligned = None if found.identification is None else found.identification.alignment
        doubt = "" if aligned is None else scale_doubt(aligned.gain)
        parts += [Paragraph(doubt)] if doubt else []
    return Told(verdict, "bad" if fit is None else "good", _measured(found), tuple(parts))


def _measured(found: Findings) -> tuple[Part, ...]:
    info, recording = found.session.info, found.recording
    day = info.created.astimezone(UTC).strftime("%Y-%m-%d")
    channels = ", ".join(
        f"{channel.name}{f' by {channel.sensor}' if channel.sensor else ''} ({_calibrated(channel.calibration_uncertainty)})"
        for channel in recording.channels
    )
    taken = "" if found.verdict is None else f", {found.verdict.grade.value}"
    seconds = recording.samples.shape[1] / recording.rate
    warning = (Paragraph(found.doubt, label="Warning", strong=True),) if found.doubt else ()
    return warning + facts(
        (
            ("specimen", info.specimen or NOT_STATED),
            ("test", f"free decay, {'recorded' if info.board else 'imported'} {day}, {seconds:.4g} s{taken}"),
            ("operator", info.operator or NOT_STATED),
            ("mass", mass_words(found.weighing)),
            ("sensors", channels),
        )
    )


def _calibrated(uncertainty: float | None) -> str:
    return "calibration not stated" if uncertainty is None else f"calibrated to {100 * uncertainty:.2g} %"


def _explaining(found: Findings) -> tuple[Fit, str] | None:
    """Choose the model that explains the record, the current one, else the identified one, and say so; None without."""
    current, adequate = found.compared, None
    if found.identification is not None:
        adequate = found.identification.adequacy
    if adequate is not None and adequate.doubt:
        return None
    if current is not None and current.judged.at_floor:
        judged = current.judged
        return _explained(current.words, judged.stated(judged.fit), current.left)
    if adequate is not None and adequate.adequate:
        left = residual_words(adequate.error.motion_percent, adequate.error.chi_square)
        rest = "too little to name an effect by" if adequate.negligible else _NOISE
        return _explained("the identified model", adequate.fit, left, rest)
    return None


def _explained(words: str, fit: Fit, left: str, rest: str = _NOISE) -> tuple[Fit, str]:
    names = " + ".join(plain_name(name) for name in fit.model.names)
    said = f"{sentence(words).rstrip('.')} explains the measurement: {names}. Its residual is {left}, {rest}."
    return fit, said


def _nothing_explains(found: Findings) -> str:
    if found.identification is None:
        return f"nothing was identified: {found.left_out['identification']}"
    own, current, diagnosis = found.identification.adequacy, found.compared, found.diagnosis
    if own is not None and own.doubt:
        return f"no value may be quoted: {own.doubt}"
    if current is None:
        reason = found.identification.refusals.get("adequacy", "no model was fitted to this record")
        return f"no value may be quoted: {judgement(own) if own is not None else reason}"
    words = f"no value may be quoted: {current.words} leaves {current.left}"
    if diagnosis is not None and diagnosis.named and diagnosis.is_of(current.baseline.fit.model.names):
        named = among([plain_name(name) for name in diagnosis.named])
        return f"{words}. {verdict_line(diagnosis)}. Add {named}, and write the report again"
    return words


def _values(fit: Fit, found: Findings) -> Table:
    """Make the table of what a test report quotes, each value with the parts of its error."""
    mass, std = found.weighing.mass, found.weighing.mass_std
    share = None if mass is None or std is None else std / mass
    aligned = None if found.identification is None else found.identification.alignment
    calibration = calibration_of(found.recording, None if aligned is None else aligned.gain.value)
    length = fit.windows[0].unit
    rows = []
    for one in engineering_values(fit, found.weighing):
        parts = budget(one, calibration, share, length)
        value, unit = with_error(one.value.value, parts.readings), typeset_unit(one.value.unit) or "1"
        shares = [_part(part, NOT_STATED) for part in (parts.calibration, parts.mass)]
        total = UNKNOWN if parts.total is None else f"± {_two(parts.total)}"
        rows.append((one.name, value, unit, *shares, total))
    head = ("quantity", "value ± readings and clock", "unit", "calibration", "mass", "total")
    return Table("", head, tuple(rows))


def _part(error: float | None, missing: str) -> str:
    return missing if error is None else DASH if error == 0.0 else f"± {_two(error)}"


def _two(error: float) -> str:
    """Write an error with two figures."""
    return three_figures(error) if error >= 100.0 or error < 1e-7 else f"{error:.{decimals_for(error)}f}"
