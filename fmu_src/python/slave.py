"""Model of the Python flavour: the functions of model.h for python_model.c, over ReferenceRope.

The FMI functions, and all rules about values, modes and states, are those of both flavours
(fmu_src/shell).  This class converts entries to scene and end motions, and
signals to outputs.  Entries are finite numbers, choices in range.  A method that returns False
leaves the rope unchanged, with the reason in ``message``.

The export copies this file and the packages that it imports into the FMU under names with the
build's hash: modules of the same name from two FMUs would be one module in the host's process.  It
must define exactly one class, by which pythonfmu's builder and python_model.c find it.
"""

import json
import logging
from collections.abc import Callable
from pathlib import Path
from typing import Any, Concatenate, ParamSpec
from xml.etree.ElementTree import Element

from pythonfmu import Fmi2Slave

from fmu_src.interface import ACCURACY, INPUTS_AT_STEP_END, MOTION, case_with, variables
from fmu_src.model_description import MODEL, Build, model_description
from fmu_src.profile import Profile
from fmu_src.python.flavour import PYTHON_DESCRIPTION, of_python, require_for_python
from rope_model.boundary.end_paths import EndMotion
from rope_model.interface import Status
from rope_model.messages.rules import first_text
from rope_model.parameters import Scene
from rope_model.reference.outputs import values_function
from rope_model.reference.result_warnings import COMPUTED, warning_of
from rope_model.reference.rope import ReferenceRope
from rope_model.reference.state import State
from rope_model.scene_names import Value, scene_with_values
from rope_model.warnings.warning_rules import LONG_EXTRAPOLATION

log = logging.getLogger(__name__)

P = ParamSpec("P")


def _report_failure(
    call: Callable[Concatenate[Any, P], None],
) -> Callable[Concatenate[Any, P], bool]:
    """Make ``call`` a method that returns whether it succeeded.

    The text of its exception is kept as ``message``.
    """

    def method(self: Any, /, *arguments: P.args, **keywords: P.kwargs) -> bool:
        try:
            call(self, *arguments, **keywords)
            return True
        except (ValueError, RuntimeError) as error:
            self.message = str(error)
        except KeyboardInterrupt:
            self.message = "interrupted from the keyboard"
        except Exception as error:
            self.message = f"internal error, please report it: {error!r}"
            log.exception("internal error")
        return False

    return method


class RopeSlave(Fmi2Slave):  # type: ignore[misc]
    """Published system of the balance rope for co-simulation."""

    #: number of warnings: those of the rope, and inputs that are extrapolated too far
    warnings = len(COMPUTED) + 1

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.modelName = MODEL
        self._resources = Path(kwargs["resources"])
        self._build = json.loads((self._resources / "build.json").read_text(encoding="utf-8"))
        self._table = variables(
            case_with(self._build["case"], self._build["level"], self._build["start"])
        )
        self._indices = {v.name: i for i, v in enumerate(self._table)}
        self._texts: dict[int, str] = {}  # texts by scalar, whose addresses the library hands out
        self._packed: tuple[State | None, bytes] = (None, b"")
        self.message = ""

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """Return the model description from our own table.

        pythonfmu's has no units and no initial unknowns.
        """
        build = self._build
        tolerance = next(float(v.start or 0.0) for v in self._table if v.name == ACCURACY)
        facts = Build(
            token=build["guid"],
            version=build["version"],
            tool=build["tool"],
            date=build["date"],
            stop=build["stop"],
            tolerance=tolerance,
            description=PYTHON_DESCRIPTION,
            derivatives=False,
        )
        described = Profile(tuple(build["outputs"])).select(self._table)
        return model_description(of_python(described), facts)

    # life

    @_report_failure
    def create(self, values: memoryview, outputs: memoryview, known: memoryview) -> None:
        """Create a rope with the parameters in ``values``.

        The arrays belong to the library and outlive this object.
        """
        self._values = values.cast("d")
        self._outputs = outputs.cast("d")
        self._known = known
        scene = self._scene()
        require_for_python(scene)
        self._rope = ReferenceRope(scene)

    @_report_failure
    def initialize(self, t: float) -> None:
        """Hang the rope at rest at the time ``t`` between its ends."""
        _require(self._rope.initialize(t, *self._motions()))

    @_report_failure
    def do_step(self, current_time: float, step_size: float) -> None:
        """Advance by ``step_size``, with inputs of the step's end or extrapolated to it."""
        stop = current_time + step_size
        time_of_inputs = stop if self._at_step_end() else current_time
        _require(self._rope.advance_to(stop, *self._motions(), time_of_inputs))

    @_report_failure
    def retune(self) -> None:
        """Continue with other tunable parameters."""
        scene = self._scene()
        require_for_python(scene)
        self._rope.retune(scene)

    def time(self) -> float:
        """Return the present instant of the rope, s."""
        return self._rope.time

    # results

    @_report_failure
    def compute(self, scalar: int) -> None:
        """Write the output and its group into the library's array."""
        name = self._table[scalar].name
        group = values_function(name)
        if group is None:
            raise ValueError(f"the Python flavour has no output {name}; export with --native")
        for each, value in group(self._rope.scene, self._rope.state).items():
            index = self._indices[each]
            self._outputs[index] = value
            self._known[index] = 1

    def text(self, scalar: int) -> str:
        """Return an output that is a text."""
        name = self._table[scalar].name.removeprefix("status.")
        if name == "warning":
            texts = (self.warning(k) for k in range(self.warnings))
            text = "\n".join(x for x in texts if x)
        else:
            text = str(getattr(self._rope, name))
        self._texts[scalar] = text
        return text

    def note(self) -> str:
        """Return notes about the set-up, for the log."""
        rope = self._rope
        return f"model: {rope.fidelity}, {rope.elements} elements, {rope.fidelity_reason}"

    def warning(self, number: int) -> str:
        """Return the warning ``number``, or '' if it does not apply now."""
        rope = self._rope
        if number < len(COMPUTED):
            return warning_of(COMPUTED[number], rope.scene, rope.state)
        if self._at_step_end():
            return ""
        return first_text(LONG_EXTRAPOLATION, rope.scene, rope.state)

    # states

    def state(self) -> bytes:
        """Return the complete state of the rope."""
        if self._packed[0] is not self._rope.state:
            self._packed = self._rope.state, self._rope.save()
        return self._packed[1]

    def state_bytes(self) -> int:
        """Return the length of ``state``."""
        return len(self.state())

    @_report_failure
    def restore(self, state: memoryview) -> None:
        """Go back to a state of this rope, or of one with the same parameters."""
        self._rope.restore(bytes(state))

    # entries

    def _scene(self) -> Scene:
        values: dict[str, Value] = {}
        for v, value in zip(self._table, self._values, strict=False):
            if v.causality == "parameter" and v.kind != "Boolean":
                values[v.name] = int(value) if v.kind == "Integer" else value
        return scene_with_values(Scene(), values)

    def _motions(self) -> tuple[EndMotion, EndMotion]:
        left, right = (EndMotion(*map(self._value, names)) for names in MOTION.values())
        return left, right

    def _value(self, name: str) -> float:
        """Return the present value of a real variable."""
        return float(self._values[self._indices[name]])

    def _at_step_end(self) -> bool:
        return self._value(INPUTS_AT_STEP_END) != 0.0


def _require(status: Status) -> None:
    if not status.valid:
        raise ValueError(status.message)
