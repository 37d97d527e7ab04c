"""Vibrations of tension and torque at places in the rope: amplitudes over frequency, and the strongest frequency.

Welch's method (scipy.signal.welch): halves of the record that overlap by half, each without its linear trend and under
a Hann window. An amplitude is that of a sine that has the power of its line. What has fewer than PERIODS within such a
half is the trip, no vibration.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Array

PERIODS = 2.0
"""Periods in half the record from which on it is a vibration [assumed]."""

STANDS_OUT = 2.0
"""How many times as high as the valleys about it a peak is at least: that of a trip alone has waves [assumed]."""

SHORTEST = 16
"""Rows of the shortest record that has a spectrum."""


class Spectra(NamedTuple):
    """Spectra of several places."""

    frequency: Array  # Hz, (n,), of vibrations alone
    amplitude: Array  # (n, places)


class Strongest(NamedTuple):
    """The highest peak of each spectrum that STANDS_OUT; no frequency (NaN) and the amplitude 0 where there is none."""

    frequency: Array  # Hz, (places,)
    amplitude: Array


def spectra(time: Array, values: Array) -> Spectra:
    """Return spectra of `values` (rows, places) at even times [s]; empty for a short record, NaN where values are."""
    rows, places = values.shape
    if rows < SHORTEST:
        return Spectra(np.empty(0), np.empty((0, places)))
    from scipy.signal import welch  # slow to load, and most runs record no stations

    step = float(np.median(np.diff(time)))
    known = np.isfinite(values).all(axis=0)
    frequency, power = welch(
        np.where(known, values, 0.0), 1.0 / step, nperseg=rows // 2, detrend="linear", scaling="spectrum", axis=0
    )
    kept = frequency * step * (rows // 2) >= PERIODS
    return Spectra(frequency[kept], np.where(known, np.sqrt(2.0 * power[kept]), np.nan))


def strongest(found: Spectra) -> Strongest:
    """Return the strongest frequency and amplitude at each place."""
    places = found.amplitude.shape[1]
    frequency, amplitude = np.full(places, np.nan), np.zeros(places)
    if found.frequency.size:
        from scipy.signal import find_peaks

        for k, column in enumerate(found.amplitude.T):
            with np.errstate(divide="ignore"):  # nothing at all vibrates
                peaks = find_peaks(np.log(column), prominence=np.log(STANDS_OUT))[0]
            if peaks.size:
                best = peaks[np.argmax(column[peaks])]
                frequency[k], amplitude[k] = found.frequency[best], column[best]
            elif not np.isfinite(column).all():
                amplitude[k] = np.nan
    return Strongest(frequency, amplitude)
