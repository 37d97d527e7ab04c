"""The runs behind the published evaluation: some ten minutes."""

from evidence.reproduction import costs, frequencies, release, windings
from evidence.tables import Measures

MEASURES: Measures = {
    "frequencies": frequencies.measure,
    "windings": windings.measure,
    "costs": costs.measure,
    "release": release.measure,
}
