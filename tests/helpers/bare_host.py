"""A host that knows nothing of this project: simulates FMUs and systems by FMPy, and prints what came of it as JSON.

Arguments: pairs of a name and a path of an FMU, of the folder of an unpacked one, or of an SSP.  Of each it prints the
last values of its first outputs, or the exception, and at the end all modules that bear names of the project, with the
version that a module ``version`` of them states.
"""

import json
import sys
import tempfile
import zipfile
from pathlib import Path

import fmpy
from fmpy.ssp.ssd import read_ssd

#: names that modules of the project, and what it brings into the Python FMU, begin with
OURS = ("rope_model", "fmu_src", "hoist_demo", "balance_rope", "pythonfmu")
OUTPUTS = 6  #: outputs that are read
STOP = 0.03  #: s
STEP = 0.01  #: s


def simulated(path: str) -> list[float]:
    """Return time and outputs at the end of a short simulation with the start values."""
    description = fmpy.read_model_description(path)
    outputs = [
        v
        for v in description.modelVariables
        if v.causality == "output" and v.type in ("Real", "Float64")
    ]
    names = [v.name for v in outputs if not v.dimensions][:OUTPUTS]
    result = fmpy.simulate_fmu(
        path, stop_time=STOP, step_size=STEP, output_interval=STEP, output=names
    )
    return [float(value) for value in result[-1]]


def members(path: str) -> list[str]:
    """Return the paths of the FMUs of a system, unpacked, in the order in which its description names them."""
    folder = tempfile.mkdtemp()
    with zipfile.ZipFile(path) as archive:
        archive.extractall(folder)
    return [str(Path(folder, component.source)) for component in read_ssd(path).system.elements]


def result(path: str) -> object:
    try:
        if path.endswith(".ssp"):
            return [simulated(member) for member in members(path)]
        return [simulated(path)]
    except Exception as error:
        return repr(error)


def main() -> None:
    given = sys.argv[1:]
    results = {name: result(path) for name, path in zip(given[::2], given[1::2], strict=True)}
    own = {
        name: getattr(module, "__version__", "")
        for name, module in sys.modules.items()
        if name.startswith(OURS)
    }
    print(json.dumps({"results": results, "modules": own}))


if __name__ == "__main__":
    main()
