"""A study file is checked whole, and its runs are named by their data."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import pytest

from hoist_demo.control.controller import Gains
from hoist_demo.design.optimal_trajectory import TrajectoryOptions
from hoist_demo.design.shaping import Shaper
from hoist_demo.parameters import Coupling, Hoist, Winding
from hoist_demo.parameters.quantity import Parameter, quantity
from hoist_demo.study.catalogue import leaves, with_values
from hoist_demo.study.definition import Study, read_study
from hoist_demo.study.metrics import Arrival
from hoist_demo.study.reading import StudyError
from hoist_demo.study.run import build
from hoist_demo.study.tuning import Range, latin_hypercube

Read = Callable[..., Study]


@pytest.fixture
def read(tmp_path: Path, fmu_of: Callable[[str], Path]) -> Read:
    """Reads the text of a study file, which it writes; with the draft FMU if none is given."""

    def read(text: str, rope: Path | None = None) -> Study:
        path = tmp_path / "STUDY.toml"
        path.write_text(f'study.fmu = "{rope or fmu_of("draft")}"\n{text}', encoding="utf-8")
        return read_study(path)

    return read


# the file


def test_grid_is_run_for_every_variant(read: Read) -> None:
    study = read(
        "[[variant]]\nname = 'soft'\nvalues = { rope.EI = 50 }\n"
        "[[variant]]\nname = 'stiff'\nvalues = { rope.EI = 500 }\n"
        "[vary]\ncontroller = ['pi', 'pi-feed-forward']\nwinding.jerk = { values = [0.5, 1], unit = 'm/s3' }"
    )
    assert len(study.samples) == 2 * 2 * 2
    assert {(s.variant, s.data.fmu["rope.EI"]) for s in study.samples} == {("soft", 50.0), ("stiff", 500.0)}
    assert {(s.data.controller, s.data.winding.jerk) for s in study.samples} == {
        (c, j) for c in ("pi", "pi-feed-forward") for j in (0.5, 1.0)
    }


TUNE = "tune.minimise = { cycle_time = 1 }\n"
RANGE = "[vary]\nrope.EI = { low = 1, high = 2 }"

BAD = {
    "unknown table": ("[vry]\nrope.EI = [1]", "[vry]", "the tables are"),
    "unknown case": ("study.case = 'rope-12'", "'rope-12'", "rope-120"),
    "unknown parameter": ("[fixed]\nwinding.sped = 8", "winding.sped", "winding.speed"),
    "wrong unit": ("[fixed]\nrope.EI = { value = 300, unit = 'N.m' }", "'N.m'", "'N.m2'"),
    "impossible field": ("[fixed]\nwinding.jerk = -1", "winding.jerk = -1.0", "above 0"),
    "impossible FMU value": ("[vary]\nrope.EI = [300, -1]", "rope.EI = -1", "at least 1e-15"),
    "outside the FMU's bounds": (
        "[fixed]\nleft.swivel.mode = 7",
        "left.swivel.mode = 7",
        "0 (locked), 1 (free), 2 (coulomb)",
    ),
    "FMU values that do not fit": ("[fixed]\nleft.swivel.mu_static = 1e-4", "0.0001", "mu_kinetic"),
    "file that is not there": ("[fixed]\nfrom = 'nowhere.toml'", "nowhere.toml", "give an existing file"),
    "text for a number": ("[fixed]\nrope.EI = 'stiff'", "'stiff'", "finite number"),
    "not whole": ("[fixed]\nmesh.elements = 3.5", "3.5", "whole"),
    "trip longer than the shaft": ("[fixed]\nwinding.travel = 900", "900", "shaft_travel"),
    "list where one value belongs": ("[fixed]\nrope.EI = [1, 2]", "rope.EI", "[vary]"),
    "range in a grid": ("[vary]\nrope.EI = { low = 1, high = 2 }", "rope.EI", "values"),
    "logarithm of zero": ("[vary]\nrope.beta_K = { low = 0, high = 1, scale = 'log' }", "0.0", "linear"),
    "no number of runs": (
        "sample.method = 'latin-hypercube'\n[vary]\nrope.EI = { low = 1, high = 2 }",
        "runs",
        "whole",
    ),
    "unknown metric": ("tune.minimise = { speed = 1 }\n[vary]\nrope.EI = { low = 1, high = 2 }", "speed", "cycle_time"),
    "bound on no metric": (TUNE + "tune.subject_to = { speed = { below = 1 } }\n" + RANGE, "speed", "cycle_time"),
    "bound in another unit": (
        TUNE + "tune.subject_to = { sway = { below = 300, unit = 'mm' } }\n" + RANGE,
        "'mm'",
        "convert",
    ),
    "more searches than points": (TUNE + "tune.sample = 1\n" + RANGE, "searches = 2", "at most sample = 1"),
    "designed trip with an emergency stop": (
        "[fixed]\ncontroller = 'input-shaping'\nwinding.emergency_at = 5",
        "emergency_at = 5",
        "pi-feed-forward",
    ),
    "optimised trip with creep": (
        "[fixed]\ncontroller = 'optimised-trajectory'\nwinding.creep_distance = 3",
        "creep_distance = 3 m",
        "another controller",
    ),
    "creep speed in another unit": ("[fixed]\nwinding.creep_speed = { value = 0.5, unit = 'mm/s' }", "mm/s", "m/s"),
    "two best runs": ("study.minimise = 'cycle_time'\nstudy.maximise = 'slip_safety'", "cycle_time", "keep one"),
    "unknown signal": ("study.signals = ['loop.jaw']", "loop.jaw", "loop.yaw"),
    "a jam out of the way": (
        "study.case = 'jammed-conveyance'\n[fixed]\nwinding.travel = 10",
        "jam_right.height = 45.0 must be within 2 m of 80 to 90 m",
        "wind further",
    ),
    "not TOML": ("[fixed", "not TOML", "correct"),
}


@pytest.mark.parametrize(("text", "value", "cure"), BAD.values(), ids=BAD.keys())
def test_bad_file_is_refused_with_file_key_value_and_cure(read: Read, text: str, value: str, cure: str) -> None:
    with pytest.raises(StudyError) as refused:
        read(text)
    assert len(refused.value.problems) == 1, refused.value.problems
    assert "STUDY.toml: " in str(refused.value)
    assert value in str(refused.value)
    assert cure in str(refused.value)


def test_all_errors_are_told_at_once(read: Read) -> None:
    with pytest.raises(StudyError) as refused:
        read("study.sene = 3\n[fixed]\nwinding.sped = 8\nwinding.jerk = -1\ncontroller = 'pid'\n[vary]\nrope.EI = [-1]")
    told = "\n".join(refused.value.problems)
    assert [name in told for name in ("sene", "winding.sped", "winding.jerk", "pid", "rope.EI = -1")] == [True] * 5


@pytest.mark.parametrize(("key", "sense"), [("minimise", "min"), ("maximise", "max")])
def test_a_grid_may_name_the_metric_that_chooses_the_best_run(read: Read, key: str, sense: str) -> None:
    study = read(f"study.{key} = 'slip_safety'\n[vary]\nwinding.jerk = [0.5]")
    assert study.best == {"metric": "slip_safety", "sense": sense}
    assert read("[vary]\nwinding.jerk = [0.5]").best is None


# units and samples


@pytest.mark.parametrize("data", [Hoist, Winding, Coupling, Gains, Shaper, TrajectoryOptions, Arrival])
def test_every_field_states_a_unit(data: type) -> None:
    symbols = {
        "1",
        "s/m",
        "m",
        "kg",
        "s",
        "N",
        "Hz",
        "rad",
        "N.m",
        "N.m2",
        "N.s/m",
        "kg/m",
        "m/s",
        "m/s2",
        "m/s3",
        "1/s",
    }
    symbols |= {"s/m", "kg.m2", "N/m", "N.m/rad", "N.m.s/rad", "W", "N.m/s", "rad/s", "deg"}
    assert {leaf.unit for leaf in leaves(data)} <= symbols


@dataclass(frozen=True)
class Part:
    delay: float = quantity(0.5, "s")
    share: float = quantity(0.1, "-")

    def __post_init__(self) -> None:
        if self.share > self.delay:
            raise ValueError(f"share = {self.share} must be at most delay = {self.delay}")


@dataclass(frozen=True)
class Whole:
    count: int = quantity(3, "-", "of things")
    part: Part | None = quantity(None, "", "none: without")
    limit: float | None = quantity(None, "N m", "None: none")
    name: str = "a"


def test_parts_are_reached_by_dotted_names() -> None:
    assert list(leaves(Whole)) == [
        Parameter("count", "1", "Integer"),
        Parameter("part.delay", "s", "Real"),
        Parameter("part.share", "1", "Real"),
        Parameter("limit", "N.m", "Real"),
        Parameter("name", "1", "String"),
    ]
    assert with_values(Whole(), {"part.share": 0.9, "part.delay": 1.0, "limit": 2.0}) == Whole(3, Part(1.0, 0.9), 2.0)


def test_latin_hypercube_has_one_sample_in_each_strip() -> None:
    samples = latin_hypercube({"a": Range(2.0, 4.0), "b": Range(1.0, 1e4, logarithmic=True)}, 50, seed=3)
    strips = {int((s["a"] - 2.0) / 2.0 * 50) for s in samples}, {int(math.log10(s["b"]) / 4 * 50) for s in samples}
    assert strips == (set(range(50)), set(range(50)))


def test_key_changes_with_every_piece_of_data() -> None:
    base = build("rope-120", {"rope.EI": 300.0})
    others = [
        build("rope-120", {"rope.EI": 301.0}),
        build("rope-120", {"rope.EI": 300.0, "gains.speed": 1e5}),
        build("rope-120", {"rope.EI": 300.0, "arrival.window": 4.0}),
        build("rope-120", {"rope.EI": 300.0, "controller": "pi"}),
        build("rope-120", {"rope.EI": 300.0}, signals=("loop.x",)),
    ]
    keys = [base.key("bytes"), base.key("other bytes"), *(run.key("bytes") for run in others)]
    assert len(set(keys)) == len(keys)
    assert build("rope-120", {"rope.EI": 300.0}).key("bytes") == base.key("bytes")


def test_key_keeps_clear_of_what_the_controller_does_not_use() -> None:
    plain, other = build("rope-120", {}), build("rope-120", {"shaper.frequency": 2.0, "trajectory.hold": 2.0})
    assert plain.key("bytes") == other.key("bytes")
    shaped = [build("rope-120", {"controller": "input-shaping", "shaper.frequency": f}) for f in (1.0, 2.0)]
    assert shaped[0].key("bytes") != shaped[1].key("bytes")
