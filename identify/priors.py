"""The priors, assumed before a recording is seen: every constant that turns evidence into a verdict.

Half and twice each value, on the rigs and on drawn recordings: `docs/decisions/one-evidence.md`.
"""

import numpy as np

SIZES = np.array([0.0, *np.geomspace(1e-4, 0.3, 8)])
"""Sizes that a random walk (share of the spring, after one radian of motion) and a law outside the library (share of the
spring or of twice the critical damping) may have: none, or steps of a factor of 3.1 up to where a rig is no oscillator."""

STRENGTHS = np.geomspace(1e-4, 1.0, 9)
"""Standard deviations that the strength of a named law may have, as a share of the spring."""

NOISE = np.geomspace(1e-7, 0.2, 25)
"""Standard deviations of the noise of a curve, as a share of the amplitude: of a converter of 24 bits to useless."""

WALKS_ARE = 1.0
"""Nats against each step of a random walk's size: every rig has one, small ones are likelier."""

NAMELESS_IS = 0.5
"""Nats against each step of the size of a law outside the library: a large one is rarer than one of the library."""

RARE = 1.0
"""Nats against an effect for each unit of its rarity."""

FLAT = 10.0
"""Standard deviation of spring, friction and damper in units of the spring: as good as unknown."""

SAME = 0.02
"""Share of the spring by which gravity may differ from it where it is the whole spring: the calibration of an angle."""

BENDS_OVER = 0.8
"""Ratio of amplitudes, as a natural logarithm, over which a law outside the library may bend."""

LEAKS = (0.1, 0.1, 1.0)
"""Share of what a window's harmonic motion leaves of the reading that is an error of its amplitude, phase and centre."""

DRIFTS = 1.0
"""Nats against a law of time beside the random walks that every hypothesis has: few rigs drift by a law."""

WALK_IS_KNOWN = 2.5e-4
"""Share of the evidence for a random walk beside a name that is error: between its knots it is taken for straight."""

DOUBT = 0.02
"""Probability that may be left out: that nothing is there, that a law of time is behind it, that it is none of a class."""

DOUBT_AT_A_GUESS = 2e-4
"""The same of nothing, where the noise floor could only be guessed and free runs are all there is."""

MOST_ALIKE = 4
"""Laws that are not distinguishable and still make a class worth telling."""

LARGE = 0.5
"""Prediction error, in % of the motion, that a law must remove to be large enough for a name."""

LEAVES = 0.4
"""Share of the error of its frequency or loss, in parts that were left out, that a law may leave to be confirmed."""

NEGLIGIBLE = 0.1 * LARGE
"""Percent of the motion below which a misfit above a guessed floor is nothing missing: a tenth of what a name asks."""

RIVALS_WITHIN = -float(np.log(DOUBT))
"""Nats of evidence below which two suspects count as not distinguishable: the worse one has more than DOUBT of the odds."""

DECIDES = 3.0 * RIVALS_WITHIN
"""Nats beyond which more decide nothing more: three times what distinguishes two hypotheses."""

ADEQUATE = 3.0
"""Standard errors by which a reduced chi-square may exceed 1 and still count as at the floor."""

BENEFIT_OF_DOUBT = 0.5
"""Excess of the reduced chi-square that is left to the noise where its floor could only be guessed."""

SPEAKS_AGAINST = 1e-3
"""Probability below which a residual at the motion's harmonics is no noise, and the model that left it not adequate."""

NEXT_TO_NOTHING = 0.01
"""Share of chi-square that a force may leave which the free run alone names, where the floor is a guess."""

CLEAR = 3.0
"""Standard errors by which two numbers must differ to be two: a strength and none, two frequencies, a spring and gravity."""

AGREES = 1.5
"""Factor within which curves and free run must agree on the strength of an effect that the curves confirm."""

FEWEST_CYCLES = 5.0
"""Cycles of all releases together, below which effects are not distinguishable."""

HARDLY_KNOWN = 0.5
"""Standard error from which on a guessed floor may be zero, at two of them: it would accept any residual."""

SMALL = 0.1
"""Share of a name's evidence up to which a law beside it is small: a law that takes more is not told from the name."""

STIFFNESS_VARIES = 0.02
"""Standard deviation of a release's own spring, as a share of that of all releases: clamping, temperature."""

DAMPING_VARIES = 1.0
"""The same of its damper, as a share of the mean loss: air and supports change more."""
