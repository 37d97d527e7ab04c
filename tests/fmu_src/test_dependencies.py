"""What ModelStructure says of dependencies is true, in every FMU that is exported."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from exports import FLAVOURS
from native_host import H, Host

KINDS = [
    pytest.param(kind, marks=[pytest.mark.slow] * (kind == "python")) for kind in sorted(FLAVOURS)
]
KINDS += ["drive-2", "drive-3"]


@pytest.fixture(scope="module", params=KINDS)
def host(request: Any, unpacked: Callable[[str], tuple[Path, str]]) -> Iterator[Host]:
    made = Host(*unpacked(request.param))
    yield made
    made.free()


def names(host: Host, causality: str) -> list[str]:
    return [v.name for v in host.variables.values() if v.causality == causality]


def outputs(host: Host) -> str:
    """All of them; NaN is equal to itself here."""
    return repr(host.get(*names(host, "output")))


def nudge(host: Host, name: str) -> None:
    """The variable changed by a little that every model takes in one step."""
    host.set(**{name: host.get(name)[0] - 1e-6})


def test_no_input_and_no_parameter_changes_an_output_before_the_next_step(host: Host) -> None:
    host.call("Reset")
    host.start()
    for k in range(3):
        assert host.step(k * H) == ""
    before = outputs(host)
    for name in names(host, "input"):
        nudge(host, name)
        assert outputs(host) == before, name
    for v in host.variables.values():
        if v.variability == "tunable" and v.type in ("Real", "Float64"):
            host.set(**{v.name: 0.99 * host.get(v.name)[0]})
            assert outputs(host) == before, v.name
    host.set(**{name: 0.0 for name in names(host, "input") if "lean" in name})  # of plumb ends
    assert host.step(3 * H) == ""
    assert outputs(host) != before


def test_inputs_act_on_the_outputs_while_initialising(host: Host) -> None:
    host.call("Reset")
    host.enter()
    before = outputs(host)
    # not the rope's speeds: a run starts from rest; the drive's conveyances hang in the middle of their guides
    for name in names(host, "input"):
        if name.partition(".")[2] not in ("x", "y", "z", "yaw", "fy_mean"):
            continue
        nudge(host, name)
        after = outputs(host)
        assert after != before, name
        before = after


def test_initial_unknowns_name_what_acts_on_them(host: Host) -> None:
    """The rope's follow all, by default; the drive's are listed, and follow that and nothing else."""
    listed = {
        x.variable.name: x.dependencies
        for x in host.description.initialUnknowns
        if x.dependencies is not None
    }
    if host.description.modelName == "BalanceRope":
        assert not listed
        return
    host.call("Reset")
    host.enter()
    acting: dict[str, set[str]] = {name: set() for name in listed}
    changed = [v for v in host.variables.values() if v.type in ("Real", "Float64")]
    inputs = [v for v in changed if v.causality == "input"]
    # the start pulls act where the inputs are 0
    starts = [v for v in changed if v.name.endswith(".fy_start")]
    for v in (
        *inputs,
        *(v for v in changed if v.causality == "parameter" and v not in starts),
        None,
        *starts,
    ):
        if v is None:
            host.set(**{one.name: 0.0 for one in inputs})
            continue
        before = host.get(*listed)
        host.set(**{v.name: 0.99 * host.get(v.name)[0]})
        # tens of newtons; the state at rest is known to rounding
        for name, x, y in zip(listed, before, host.get(*listed), strict=True):
            if abs(x - y) > 1e-6:
                acting[name].add(v.name)
    expected = {}
    for name, follows in listed.items():
        expected[name] = {v.name for v in follows}
    assert acting == expected
    assert {name for name, follows in acting.items() if not follows} >= {
        "left.y",
        "left.vy",
        "left.ay",
        "right.ay",
    }
    outputs = (
        v
        for v in host.variables.values()
        if v.causality == "output" and v.type in ("Real", "Float64")
    )
    assert set(listed) == {v.name for v in outputs}
