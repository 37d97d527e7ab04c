"""Spectra of what was recorded at several places, and the strongest peak of each."""

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
    """Return spectra of ``values`` (rows, places) at even times [s].

    Empty for a short record, NaN where values have NaN.

    Welch's method (scipy.signal.welch): halves of the record that overlap by half, each without its
    linear trend and under a Hann window. An amplitude is that of a sine that has the power of its
    line. What has fewer than MIN_PERIODS within such a half is the trip, no vibration.
    """
    rows, places = values.shape
    if rows < MIN_ROWS:
        return Spectra(np.empty(0), np.empty((0, places)))
    from scipy.signal import welch  # slow to load, and most runs record no stations

    step = float(np.median(np.diff(time)))
    finite = np.isfinite(values).all(axis=0)
    frequency, power = welch(
        np.where(finite, values, 0.0),
        1.0 / step,
        nperseg=rows // 2,
        detrend="linear",
        scaling="spectrum",
        axis=0,
    )
    vibrates = frequency * step * (rows // 2) >= MIN_PERIODS
    return Spectra(frequency[vibrates], np.where(finite, np.sqrt(2.0 * power[vibrates]), np.nan))


def strongest(spectrum: Spectra) -> tuple[Array, Array]:
    """Return frequency [Hz] and amplitude (places,) of the highest peak above MIN_PEAK_RATIO.

    NaN and 0 without one.
    """
    places = spectrum.amplitude.shape[1]
    frequency = np.full(places, np.nan)
    amplitude = np.zeros(places)
    if spectrum.frequency.size:
        from scipy.signal import find_peaks

        for k, column in enumerate(spectrum.amplitude.T):
            with np.errstate(divide="ignore"):  # nothing at all vibrates
                peaks = find_peaks(np.log(column), prominence=np.log(MIN_PEAK_RATIO))[0]
            if peaks.size:
                best = peaks[np.argmax(column[peaks])]
                frequency[k] = spectrum.frequency[best]
                amplitude[k] = column[best]
            elif not np.isfinite(column).all():
                amplitude[k] = np.nan
    return frequency, amplitude
