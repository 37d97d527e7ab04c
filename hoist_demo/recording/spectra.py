"""Spectra of what was recorded at several places, and the strongest peak of each.

Welch's method, and peaks by their prominence, in a few lines: scipy.signal, with which the
tests compare them, takes longer to load than a trip to wind.
"""

from typing import NamedTuple

import numpy as np

from hoist_demo.recording.time_series import Array

#: Least periods in half the record; slower motion is the trip, no vibration [assumed].
MIN_PERIODS = 2.0
#: Least ratio of a spectral peak to the valleys beside it; a trip without vibration has lower ones
#: [assumed].
MIN_PEAK_RATIO = 2.0
MIN_ROWS = 16  #: Rows of the shortest record that has a spectrum.


class Spectra(NamedTuple):
    """Spectra of several places."""

    frequency: Array  # Hz, (n,), of vibrations alone
    amplitude: Array  # (n, places)


def spectra(time: Array, values: Array) -> Spectra:
    """Return spectra of `values` (rows, places) at even times [s].

    Empty for a short record, NaN where values have NaN.

    Welch's method: halves of the record that overlap by half, each without its linear trend and
    under a Hann window. An amplitude is that of a sine that has the power of its line. What has
    fewer than MIN_PERIODS within such a half is the trip, no vibration.
    """
    rows, places = values.shape
    if rows < MIN_ROWS:
        return Spectra(np.empty(0), np.empty((0, places)))
    step = float(np.median(np.diff(time)))
    finite = np.isfinite(values).all(axis=0)
    power = welch_power(np.where(finite, values, 0.0).T).T
    frequency = np.fft.rfftfreq(rows // 2, 1.0 / (1.0 / step))
    vibrates = frequency * step * (rows // 2) >= MIN_PERIODS
    return Spectra(frequency[vibrates], np.where(finite, np.sqrt(2.0 * power[vibrates]), np.nan))


def welch_power(x: Array) -> Array:
    """Return the power of each line of the half records of `x` (places, rows), (places, lines)."""
    size = x.shape[1] // 2
    hop = size - size // 2
    places = np.arange(1, size + 1) / size
    trend = np.stack([places, np.ones(size)], axis=1)
    hann = 0.5 + 0.5 * np.cos(np.linspace(-np.pi, np.pi, size + 1))[:-1]
    hann = hann * abs(1.0 / sum(hann))
    powers = []
    for begin in range(0, x.shape[1] - size + 1, hop):
        half = x[:, begin : begin + size]
        half = half - (trend @ np.linalg.lstsq(trend, half.T)[0]).T
        lines = np.fft.rfft(half * hann)
        powers.append(lines.real**2 + lines.imag**2)
    power: Array = np.mean(powers, axis=0)
    # both signs of a frequency; 0 and half the sampling rate have one
    power[:, 1 : -1 if size % 2 == 0 else None] *= 2.0
    return power


def strongest(spectrum: Spectra) -> tuple[Array, Array]:
    """Return frequency [Hz] and amplitude (places,) of the highest peak above MIN_PEAK_RATIO.

    NaN and 0 without one.
    """
    places = spectrum.amplitude.shape[1]
    frequency = np.full(places, np.nan)
    amplitude = np.zeros(places)
    if spectrum.frequency.size:
        for k, column in enumerate(spectrum.amplitude.T):
            with np.errstate(divide="ignore"):  # nothing at all vibrates
                best = highest_peak(np.log(column), float(np.log(MIN_PEAK_RATIO)))
            if best is not None:
                frequency[k] = spectrum.frequency[best]
                amplitude[k] = column[best]
            elif not np.isfinite(column).all():
                amplitude[k] = np.nan
    return frequency, amplitude


def highest_peak(x: Array, prominence: float) -> int | None:
    """Return the index of the highest peak that rises so far above both valleys beside it.

    A valley ends at a higher value or at the end of the record; a flat peak is at its middle.
    """
    begins = np.append(0, np.flatnonzero(x[1:] != x[:-1]) + 1)
    ends = np.append(begins[1:], x.size) - 1
    levels = x[begins]
    peaks = 1 + np.flatnonzero((levels[1:-1] > levels[:-2]) & (levels[1:-1] > levels[2:]))
    for peak in peaks[np.argsort(-levels[peaks], kind="stable")]:
        place = int(begins[peak] + ends[peak]) // 2
        higher = np.flatnonzero(x > x[place])
        after = int(np.searchsorted(higher, place))
        first = int(higher[after - 1]) if after > 0 else 0
        last = int(higher[after]) if after < higher.size else x.size - 1
        valleys = (np.min(x[first : place + 1]), np.min(x[place : last + 1]))
        if x[place] - max(valleys) >= prominence:
            return place
    return None
