"""Identifications built by hand from closed forms: what the views and the terminal are shown in tests."""

import numpy as np

from identify.estimate import Estimate
from identify.free_decay import FreeDecay
from identify.preprocessing.alignment import Alignment
from identify.preprocessing.release import Release
from identify.restoring_force.restoring_force import RestoringForceResult, Section
from identify.wavelet.wavelet import WaveletResult
from station.story.pipeline import Identification

MASS, STIFFNESS, FRICTION, VISCOUS = 21.36, 13115.0, 0.13, 0.277
RATE, N, RELEASE = 256.0, 2240, 192
LAG = 0.0013
OMEGA = np.sqrt(STIFFNESS / MASS)


def envelope(time):
    """Return the closed-form envelope of Coulomb and viscous friction, eq. (5), down to the stop."""
    c0, c1 = 2 * FRICTION / (np.pi * OMEGA), VISCOUS / 2
    decayed = (0.025 + c0 / c1) * np.exp(-c1 * np.maximum(time, 0)) - c0 / c1
    return np.where(time < 0, 0.025, np.maximum(decayed, 0.0))


def decay(seed: int = 7) -> FreeDecay:
    """Return a decay with the closed-form envelope, a late displacement and noise."""
    draw = np.random.default_rng(seed)
    time = (np.arange(N) - RELEASE) / RATE
    held = time < 0
    k = envelope(time)
    phase = OMEGA * np.maximum(time, 0)
    phase_late = OMEGA * np.maximum(time - LAG, 0)
    u = k * np.cos(phase_late)
    a = np.where(held, 0.0, -(OMEGA**2) * k * np.cos(phase))
    return FreeDecay(
        rate=RATE,
        displacement=u + 5e-6 * draw.standard_normal(N),
        acceleration=a + 0.01 * draw.standard_normal(N),
        release=RELEASE,
        rest=(0, RELEASE - 8),
        noise_displacement=5e-6,
        noise_acceleration=0.01,
        mass=MASS,
    )


def wavelet() -> WaveletResult:
    """Return a wavelet result on closed forms."""
    time = np.arange(RELEASE, RELEASE + 1800) / RATE
    k = envelope(time - RELEASE / RATE)
    frequency = np.linspace(2.0, 6.0, 64)
    modulus = np.exp(-0.5 * ((frequency[:, None] - OMEGA / 2 / np.pi) / 0.25) ** 2) * k[None, ::8]
    return WaveletResult(
        stiffness_by_order={1: Estimate(13115.2, 2.1, "N/m"), 3: Estimate(1000.0, 9000.0, "N/m^3")},
        damping=(Estimate(0.1302, 0.0007, "m/s^2"), Estimate(0.2765, 0.0021, "1/s")),
        order=1,
        reason="order 1 leaves no more than order 2 within the errors, and order 0 leaves 40 times more",
        mse_percent_by_order=(0.42, 0.0011, 0.0010, 0.0010),
        channel="displacement",
        time=time,
        envelope=k * (1 + 0.001 * np.sin(20 * time)),
        envelope_fit=k,
        frequency=np.full(len(time), OMEGA / 2 / np.pi) + 0.002 * np.sin(9 * time),
        frequency_fit=np.full(len(time), OMEGA / 2 / np.pi),
        trusted=(time > 0.9) & (time < 7.0),
        reconstruction=k * np.cos(OMEGA * (time - RELEASE / RATE)),
        scalogram=modulus,
        scalogram_frequency=frequency,
        scalogram_time=time[::8],
        stiffness_per_mass=Estimate(float(OMEGA**2), 0.01, "1/s^2"),
        stiffness_reason="the frequency does not change with the amplitude",
    )


def restoring_force(viscous: float = VISCOUS) -> RestoringForceResult:
    """Return a restoring force result on closed forms, with the viscous damping it is told to have found."""
    time = np.arange(RELEASE, RELEASE + 1800) / RATE
    k = envelope(time - RELEASE / RATE)
    u = k * np.cos(OMEGA * (time - RELEASE / RATE))
    v = -OMEGA * k * np.sin(OMEGA * (time - RELEASE / RATE))
    grid_u, grid_v = np.linspace(-0.025, 0.025, 41), np.linspace(-0.6, 0.6, 41)

    def force(u, v):
        return OMEGA**2 * u + FRICTION * np.sign(v) + viscous * v

    f = force(u, v)

    def section(position, values):
        return Section(
            position=position,
            force=values + 0.01 * np.cos(50 * position),
            fit=values,
        )

    return RestoringForceResult(
        stiffness_by_order={1: Estimate(13114.9, 0.6, "N/m")},
        damping=(Estimate(0.1298, 0.0004, "m/s^2"), Estimate(viscous, 0.0016, "1/s")),
        offset=Estimate(0.0002, 0.0004, "m/s^2"),
        order=1,
        reason="the error stops falling at order 1: the next term explains 0.0001 %",
        mse_percent=0.0031,
        mse_percent_by_order=(0.09, 0.0031, 0.0031, 0.0030),
        significance_percent={"u": 99.1, "sgn v": 0.02, "v": 0.03},
        source="displacement and acceleration",
        time=time,
        displacement=u,
        velocity=v,
        force=f + 0.01 * np.sin(100 * time),
        force_fit=f,
        section_zero_velocity=section(grid_u, force(grid_u, 0 * grid_u)),
        section_zero_displacement=section(grid_v, force(0 * grid_v, grid_v)),
        stiffness_per_mass=Estimate(float(OMEGA**2), 0.03, "1/s^2"),
    )


def identification() -> Identification:
    """Return a whole identification as the pipeline would return it."""
    recorded = decay()
    shift = LAG * RATE
    index = np.arange(N)
    moved = np.interp(index + shift, index, recorded.displacement)
    return Identification(
        decay=recorded,
        release=Release(
            time_s=RELEASE / RATE,
            std_s=0.0004,
            index=RELEASE,
            settle=RELEASE + 5,
            end=N - 60,
            kind="displaced",
            rest=(0, RELEASE - 8),
        ),
        alignment=Alignment(
            Estimate(LAG, 3.1e-6, "s"), Estimate(1.0012, 0.0002, "1"), "cross-spectrum from rest to rest"
        ),
        aligned=recorded.with_(displacement=moved),
        wavelet=wavelet(),
        restoring_force=restoring_force(),
        refusals={},
    )
