"""The host drives a rope of FMI 3.0, with arrays and without, as one of FMI 2.0: same names, same bits, same words."""

import logging
from collections.abc import Callable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import pytest
from exports import FLAVOURS

from hoist_demo.cases.table import find_case
from hoist_demo.cosimulation.checkpoint import Checkpoint
from hoist_demo.cosimulation.host import Host
from hoist_demo.cosimulation.participants.fmu_description import read_outputs, read_parameters
from hoist_demo.cosimulation.participants.fmu_rope import FmuRope
from hoist_demo.cosimulation.run_state import Result
from hoist_demo.parameters import Coupling, Winding
from hoist_demo.parameters.quantity import Value
from rope_model import EndMotion

pytestmark = pytest.mark.skipif("native-3" not in FLAVOURS, reason="needs a C compiler")

FMI_3 = ("native-3", "native-3-scalar")
KINDS = ("native-2", *FMI_3)
H = 0.01
AT_REST = EndMotion(y=0.0), EndMotion(y=90.0)
FmuOf = Callable[[str], Path]


def wound(fmu: Path, stop_at: float = 1.0, **options: Any) -> Result:
    """A trip of 20 cm that reads every output, the added masses too; each exchange goes back to a saved state."""
    scene = find_case("rope-120")
    trip = Winding(travel=0.2, settle=0.0, start_delay=0.0)
    rope = FmuRope(fmu, scene.rope, read_outputs(fmu))
    host = Host(rope, scene.hoist, trip, Coupling(scheme="iterative-jacobian"), scene.gains)
    try:
        return host.run(lambda fraction, t: t < stop_at, **options)
    finally:
        rope.close()


def bits(result: Result) -> dict[str, bytes]:
    return {name: values.tobytes() for name, values in result.recording.signals.items()}


def rope_at_rest(fmu: Path, parameters: Mapping[str, Value] | None = None) -> FmuRope:
    rope = FmuRope(fmu, parameters)
    assert rope.initialize(0.0, *AT_REST).valid
    return rope


@pytest.fixture(scope="module")
def whole(fmu_of: FmuOf) -> Result:
    return wound(fmu_of("native-2"))


@pytest.mark.parametrize("kind", FMI_3)
def test_a_winding_that_takes_steps_back_has_the_bits_of_fmi_2(
    kind: str, fmu_of: FmuOf, whole: Result
) -> None:
    result = wound(fmu_of(kind))
    assert result.recording.time.size > 50
    assert list(result.recording.signals) == list(whole.recording.signals)
    assert {"shape.x[81]", "status.fidelity", "left.added_mass"} <= set(result.recording.signals)
    assert bits(result) == bits(whole)
    assert result.recording.units == whole.recording.units


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_that_was_stopped_goes_on_with_the_same_bits(kind, fmu_of, whole, tmp_path):
    stopped = wound(fmu_of(kind), stop_at=0.2, save_to=tmp_path / "last_good.npz")
    assert stopped.saved is not None
    kept = Checkpoint.read(stopped.saved)
    assert bits(wound(fmu_of(kind), resume=kept)) == bits(whole)
    # a state is that of one build
    other = "native-2"
    if kind == "native-2":
        other = "native-3"
    with pytest.raises(ValueError, match=r"as a state of its own, but: .* it is another build's"):
        wound(fmu_of(other), resume=kept)


@pytest.mark.parametrize("kind", FMI_3)
def test_parameters_and_outputs_have_the_names_units_starts_and_bounds_of_fmi_2(
    kind: str, fmu_of: FmuOf
) -> None:
    ours = read_parameters(fmu_of(kind))
    theirs = read_parameters(fmu_of("native-2"))
    assert list(ours) == list(theirs)
    for name, parameter in theirs.items():
        assert ours[name] == parameter
    assert read_outputs(fmu_of(kind)) == read_outputs(fmu_of("native-2"))


def test_one_count_of_elements_is_set_and_the_others_keep_their_start_values(fmu_of: FmuOf) -> None:
    energies = []
    for kind in KINDS:
        for parameters in ({}, {"mesh.counts[3]": 48}):
            rope = rope_at_rest(fmu_of(kind), {"mesh.kind": 0, **parameters})
            energies.append(rope.reader(["energy.strain"])().item())
            rope.close()
    default, finer = energies[:2]
    assert default != finer
    assert energies[2:] == [default, finer] * 2


def test_a_choice_is_made_by_code_or_by_the_word_of_fmi_3(fmu_of: FmuOf) -> None:
    for fmu, choice in [
        ("native-2", 3),
        *product(FMI_3, (3, "planar")),
    ]:
        rope = rope_at_rest(fmu_of(fmu), {"model.fidelity": choice})
        assert rope.reader(["status.fidelity"])() == 3.0
        rope.close()
    with pytest.raises(
        ValueError, match=r"model\.fidelity = 'plane' must be one of auto, torsional"
    ):
        FmuRope(fmu_of("native-3"), {"model.fidelity": "plane"})
    for kind in KINDS:
        with pytest.raises(
            ValueError,
            match=r"must take model\.fidelity, but: .* model\.fidelity = 9 is none of the",
        ):
            FmuRope(fmu_of(kind), {"model.fidelity": 9})


def test_failures_and_warnings_are_told_in_the_same_words_and_nothing_is_printed(
    fmu_of: FmuOf, caplog: pytest.LogCaptureFixture, capfd: pytest.CaptureFixture[str]
) -> None:
    told = []
    for kind in KINDS:
        caplog.clear()
        with caplog.at_level(logging.WARNING, FmuRope.__module__):
            rope = rope_at_rest(fmu_of(kind), {"model.fidelity": 3})
            before = rope.save()
            failed = rope.step(0.0, H, EndMotion(y=50.0), AT_REST[1])
            rope.restore(before)
            again = rope.step(0.0, H, *AT_REST)
            rope.close()
        told.append((failed, again, caplog.messages))
    failed, again, warnings = told[0]
    assert (failed.valid, again.valid) == (False, True)
    assert "inputs.misfit_max" in failed.message
    assert len(warnings) == len(set(warnings)) > 0
    assert told[1:] == told[:1] * len(FMI_3)
    assert capfd.readouterr().out == ""
