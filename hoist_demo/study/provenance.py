"""Sources of the numbers that a study rests on, each with its status."""

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.participants.fmu_description import read_parameters
from hoist_demo.cosimulation.participants.rope_data import RopeData
from hoist_demo.run.provenance import SourcedValue, host_provenance, rope_provenance
from hoist_demo.study.definition import Study


def study_provenance(study: Study) -> list[SourcedValue]:
    """Return the provenance of all data of a study; what differs between runs has no value."""
    run = study.samples[0].data
    status = study.status_by_name
    parameters = read_parameters(study.fmu)
    starts = {name: parameter.start for name, parameter in parameters.items()}
    units = {name: parameter.unit for name, parameter in parameters.items()}
    rope = RopeData({}, {**starts, **run.rope_values}, units)
    return [*host_provenance(run, status), *rope_provenance(find_case(study.hoist), rope, status)]
