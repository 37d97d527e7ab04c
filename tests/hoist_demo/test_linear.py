"""Linear models: the rope's against its modes, the hoist's against masses and springs, both against co-simulation."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.sparse as sp
from numpy.testing import assert_allclose
from scipy.io import loadmat
from shared import Patch

from hoist_demo.cases.case import Case
from hoist_demo.cases.hoist_file import HoistFile
from hoist_demo.cases.table import find_case
from hoist_demo.command_line.main import main
from hoist_demo.cosimulation.participants.inprocess_rope import rope_scene
from hoist_demo.design import (
    arrival_swing,
    linear_model,
    reduced_model,
    reduction,
    sparse_modes,
)
from hoist_demo.design import linearise as linearise_module
from hoist_demo.design.arrival_swing import (
    SWING_INPUTS,
    SWING_OUTPUTS,
    SpeedLoop,
    pole_of_sparse,
    swing_at_arrival,
)
from hoist_demo.design.linear_model import LinearModel
from hoist_demo.design.linearise import linearise, linearise_hoist, linearise_rope
from hoist_demo.design.reduction import reduced
from hoist_demo.files.reading import read
from hoist_demo.parameters import GRAVITY
from hoist_demo.parameters.components import Brake
from rope_model import EndMotion
from rope_model.analysis.modes import natural_modes
from rope_model.engine import NativeRope

TORQUE = ("torque_command",)
SEEN = ("rate", "pull_left", "pull_right", "tension_left", "left.fy", "right.fy")


def smooth(case: Case) -> Case:
    """The case without what has no derivative."""
    guides = case.hoist.guides
    if guides is not None:
        guides = replace(guides, coulomb=0.0)
    return replace(
        case, hoist=replace(case.hoist, loss_coulomb=0.0, guides=guides, brake=None, play=None)
    )


@pytest.fixture
def two_ropes(tmp_path: Path) -> LinearModel:
    """A hoist with equal ropes at equal distances: every mode that it does not share is there twice."""
    ropes = "[[rope]]\nname = 'a'\nz = 0.3\n[[rope]]\nname = 'b'\nz = -0.3\n"
    path = tmp_path / "two.toml"
    path.write_text(f"name = 'two'\nlike = 'rope-120'\nlevel = 'draft'\n{ropes}", encoding="utf-8")
    case = find_case(str(path))
    (model,) = linearise(smooth(case), [0.3], level=case.level)
    return model


@pytest.fixture
def draft(tmp_path: Path) -> Path:
    """A hoist with few elements, where their errors are no claim."""
    path = tmp_path / "draft.toml"
    path.write_text("name = 'd'\nlike = 'rope-120'\nlevel = 'draft'\n", encoding="utf-8")
    return path


def taken_one_by_one(monkeypatch: Patch) -> None:
    monkeypatch.setattr(linear_model, "equal_ropes", lambda *_: [])


@pytest.mark.parametrize("merged", [True, False])
def test_sparse_modes_are_the_dense_ones_and_none_is_missed(
    merged: bool, two_ropes: LinearModel, monkeypatch: Patch
) -> None:
    model = two_ropes
    heard = list[float]()
    with monkeypatch.context() as changed:
        taken_one_by_one(changed)
        dense = model.modes(2.0)
    monkeypatch.setattr(linear_model, "MAX_DENSE_SIZE", 0)
    if not merged:
        taken_one_by_one(monkeypatch)
    found = model.modes(2.0, heard.append)
    assert found.frequencies.size == dense.frequencies.size > sparse_modes.MAX_MODES_PER_RUN
    assert heard[-1] == 1.0
    assert heard == sorted(heard)
    # a motion without stiffness has the square of its frequency 0 but for rounding, 1e-6 1/s^2 here
    assert_allclose(found.frequencies**2, dense.frequencies**2, rtol=1e-7, atol=1e-6)
    # equal modes may be mixed: their damping is compared by its sum, that of each other mode alone
    near = np.diff(dense.frequencies, prepend=-1.0) > 1e-4
    firsts = np.flatnonzero(near)
    sums = [np.add.reduceat(one.damping * one.frequencies, firsts) for one in (found, dense)]
    assert_allclose(sums[0], sums[1], rtol=1e-5, atol=1e-8)
    assert_allclose(found.shares.sum(axis=0), 1.0, rtol=0.0, atol=1e-9)


def test_equal_ropes_are_computed_once(two_ropes: LinearModel, monkeypatch: Patch) -> None:
    sizes = list[int]()

    def listening(K: sp.csc_matrix, *others: Any) -> tuple[np.ndarray, np.ndarray]:
        sizes.append(K.shape[0])
        return sparse_modes.sparse_modes(K, *others)

    monkeypatch.setattr(linear_model, "MAX_DENSE_SIZE", 0)
    monkeypatch.setattr(linear_model, "sparse_modes", listening)
    two_ropes.modes(1.0)
    of_hoist = sum(not name.startswith("rope.") for name in two_ropes.names[: two_ropes.free])
    of_a_rope = (two_ropes.free - of_hoist) // 2
    assert sizes == [of_hoist + of_a_rope, of_a_rope]
    # sideways motion moves them alike, and yaw does not, for it lies between them
    frequencies = [0.4j, 3j]
    alike = two_ropes.response(frequencies)
    along = two_ropes.selected(TORQUE, SEEN[:3]).response(frequencies)
    taken_one_by_one(monkeypatch)
    one_by_one = two_ropes.response(frequencies)
    # rounding of a response that is much smaller than the largest: 1e-16 times the condition of the model
    assert_allclose(alike, one_by_one, rtol=1e-7, atol=1e-7 * np.abs(one_by_one).max())
    expected = two_ropes.selected(TORQUE, SEEN[:3]).response(frequencies)
    assert_allclose(along, expected, rtol=1e-6, atol=1e-7 * np.abs(expected).max())


BENT = pytest.param(0, {"air.density": 1.2, "rope.initial_curvature": 0.5}, marks=pytest.mark.slow)


@pytest.mark.parametrize(("mode", "more"), [(0, {}), (1, {}), BENT])  # locked, free
def test_rope_alone_has_its_natural_modes(mode: int, more: dict[str, float]) -> None:
    scene = rope_scene(
        {**find_case("rope-120").rope, "left.swivel.mode": mode, "right.swivel.mode": mode, **more}
    )
    scene = scene.with_(model=replace(scene.model, fidelity="torsional"))
    ends = EndMotion(y=20.0), EndMotion(y=70.0)
    rope = NativeRope(scene)
    assert rope.initialize(0.0, *ends).valid
    assert rope.release_free_swivels().valid
    modes = natural_modes(rope, 8)
    found = linearise_rope(scene, *ends)
    # the frame's turn is integrated from another reference; a rope in free swivels spins
    assert_allclose(found.modes(1.0).frequencies[mode:8], modes.frequencies[mode:], rtol=3e-6)
    assert modes.frequencies[0] > 0.01 or mode == 1
    torques = [found.rest_outputs[found.outputs.index(f"{side}.my")] for side in ("left", "right")]
    assert (np.abs(torques) < 1e-6).all() == (mode == 1)
    # a rope that is lifted as a whole is a mass
    lifted = found.response([0.01j])[0]
    rows = [found.outputs.index(f"{side}.fy") for side in ("left", "right")]
    columns = [found.inputs.index(f"{side}.y") for side in ("left", "right")]
    weight = -scene.rope.mass_per_length * scene.rope.length
    assert_allclose(
        lifted[np.ix_(rows, columns)].sum(), weight, rtol=1e-3
    )  # (0.01 / 0.4)^2, of the lowest mode


def test_hoist_is_its_masses_and_its_brake_a_spring() -> None:
    case = smooth(find_case("rope-120"))
    hoist = replace(case.hoist, loss_viscous=0.0)
    (model,) = linearise(replace(case, hoist=hoist), [0.5])
    s = 2j * np.pi * 0.02
    gain = model.selected(("torque",), ("rate",)).response([s])[0, 0, 0]
    # as one mass: (0.02 / 0.08)^2 of the loop's swing, which some hundredth of the mass takes part in
    assert_allclose(s * gain * hoist.sheave_radius**2 * hoist.moving_mass, 1.0, rtol=3e-3)

    braked = replace(hoist, brake=Brake(torque=5e5))
    model = linearise_hoist(replace(case, hoist=braked), 0.5, "brake")
    gain = model.selected(("force_left",), ("y_left",)).response([1e-3j])[0, 0, 0]
    free = hoist.sheave_height - 45.0
    spring = 5e5 / (hoist.sheave_radius * braked.brake.travel)
    # longer head ropes weigh more on either side: 2 mu g against EA / l
    assert_allclose(
        gain, free / hoist.rope_stiffness + 1 / (spring - 2 * hoist.rope_mass * GRAVITY), rtol=3e-3
    )


@pytest.mark.parametrize("speed", [8.0, -8.0])
def test_a_rope_that_flows_pulls_by_its_momentum_and_keeps_its_shape(speed: float) -> None:
    case = smooth(find_case("rope-120"))
    (still,), (moving,) = (linearise(case, [0.4], speed=v) for v in (0.0, speed))
    more = dict(zip(moving.outputs, moving.rest_outputs - still.rest_outputs, strict=True))
    rho = rope_scene(case.rope).rope.mass_per_length
    # bending's damping takes a little force; 5e-4 m of stretch
    assert_allclose([more["left.fy"], more["right.fy"]], -rho * speed**2, rtol=2e-3)
    assert abs(more["loop.y"]) < 2e-3
    assert more["v_left"] == speed
    # viscous losses at the rim, to which the damping of the rope adds its own
    assert_allclose(
        more["torque"], case.hoist.loss_viscous * case.hoist.sheave_radius * speed, rtol=2e-3
    )


@pytest.mark.slow
def test_small_models_need_no_more_states_than_the_drive_feels() -> None:
    small = reduced([m.selected(TORQUE, SEEN[:3]) for m in linearise(find_case("rope-120"))], 17)
    assert small.A.shape == (5, 17, 17)
    # promised for five heights of four hoists
    assert small.decibels.max() < 1.0
    assert small.degrees.max() < 5.0
    assert (
        np.linalg.eigvals(small.A).real.max() < 1e-6
    )  # modes of a stable model; the hoist itself rests anywhere


def test_the_number_of_states_follows_from_the_measured_error(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    (model,) = (
        m.selected(TORQUE, SEEN[:3]) for m in linearise(find_case("rope-120"), [0.3], level="draft")
    )
    few, more = (reduced([model], states) for states in (9, 15))
    bound = float(np.sqrt(few.decibels.max() * more.decibels.max()))
    assert more.decibels.max() < bound < few.decibels.max()
    monkeypatch.setattr(reduced_model, "MAX_DECIBELS", bound)
    found = reduced([model])
    assert 9 < found.A.shape[1] <= 15
    assert found.decibels.max() <= bound
    assert "errs by" not in caplog.text  # a compiler may have told of itself
    reduced([model], 9)
    assert "a model of 9 states errs by" in caplog.text
    monkeypatch.setattr(reduction, "MAX_STATES", 9)
    with pytest.raises(ValueError, match=rf"9 states errs by {few.decibels.max():.2g} dB"):
        reduced([model])


def test_an_error_of_the_computation_is_not_taken_for_too_few_motions(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (model,) = (
        m.selected(TORQUE, SEEN[:3]) for m in linearise(find_case("rope-120"), [0.3], level="draft")
    )
    few = reduced([model], 9)
    monkeypatch.setattr(reduced_model, "MAX_DECIBELS", 0.9 * float(few.decibels.max()))
    projected = reduction._projected

    def singular_beyond_9_states(of: Any, basis: Any) -> Any:
        found = projected(of, basis)
        if found[0].shape[0] > 9:
            raise np.linalg.LinAlgError("a mistake in the code")
        return found

    monkeypatch.setattr(reduction, "_projected", singular_beyond_9_states)
    with pytest.raises(np.linalg.LinAlgError, match="a mistake in the code"):
        reduced([model])


@pytest.mark.parametrize(
    ("hoist", "at"),
    [pytest.param("rope-120", 1.0), pytest.param("robert-1096", 0.5, marks=pytest.mark.slow)],
)
def test_an_arrival_swings_as_the_complete_model(hoist: str, at: float) -> None:
    case = find_case(hoist)
    case = replace(case, winding=replace(case.winding, travel=at * case.hoist.shaft_travel))
    swing = swing_at_arrival(case, 0.0)
    (model,) = linearise(case, [at])
    exact = pole_of_sparse(model.selected(SWING_INPUTS, SWING_OUTPUTS), SpeedLoop.of(case))
    assert exact is not None
    # a small model errs by 6 % in gain at most, and by less in a pole
    assert swing.frequency == pytest.approx(exact.imag / (2 * np.pi), rel=0.01)
    assert swing.damping == pytest.approx(-exact.real / abs(exact), rel=0.03)


def test_a_trip_of_half_a_deep_shaft_is_shaped_for_its_own_end() -> None:
    case = find_case("rope-120")
    half = replace(case, winding=replace(case.winding, travel=45.0))
    below, above = (swing_at_arrival(half, start) for start in (0.0, 45.0))
    assert below.frequency == pytest.approx(1.858, rel=1e-3)
    assert above == swing_at_arrival(case, 0.0)


@pytest.mark.slow
def test_where_no_small_model_serves_the_complete_one_does_or_the_error_is_told(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = find_case("rope-120")
    swing = swing_at_arrival(case, 0.0)
    monkeypatch.setattr(reduction, "MAX_STATES", 9)
    monkeypatch.setattr(reduced_model, "MAX_DECIBELS", 1e-6)
    assert swing_at_arrival(case, 0.0).frequency == pytest.approx(swing.frequency, rel=1e-3)
    monkeypatch.setattr(arrival_swing, "pole_of_sparse", lambda *_: None)
    with pytest.raises(
        ValueError,
        match=r"9 states errs by .* dB .*; nor has the complete model .* shaper.frequency",
    ):
        swing_at_arrival(case, 0.0)


def test_small_models_are_written_and_scheduled(tmp_path: Path) -> None:
    models = [m.selected(TORQUE, SEEN[:2]) for m in linearise(find_case("rope-120"), [0.2, 0.6])]
    small = reduced(models, 7)
    paths = {path.suffix: path for path in small.write(tmp_path)}
    with np.load(paths[".npz"]) as npz:
        assert_allclose(npz["A"], small.A, rtol=0, atol=0)
    assert_allclose(json.loads(paths[".json"].read_text())["C"], small.C, rtol=0, atol=0)
    assert_allclose(loadmat(paths[".mat"])["B"][..., 1], small.B[1], rtol=0, atol=0)
    plant = small.scheduled()
    X = np.arange(7.0)
    u = 2.0
    ends = [
        [A @ X + B @ [u], C @ X + D @ [u]]
        for A, B, C, D in zip(small.A, small.B, small.C, small.D, strict=True)
    ]
    for at, shares in ((0.1, (1, 0)), (0.3, (0.75, 0.25)), (0.7, (0, 1))):
        for k, found in enumerate(plant(at, X, u)):
            assert_allclose(
                found.full().ravel(), shares[0] * ends[0][k] + shares[1] * ends[1][k], rtol=1e-9
            )
    # a spline that overshoots
    rates = np.array([-50.0, -0.1, -0.1, -50.0])[:, None, None]
    four = [0, 0, 0, 0]
    steep = replace(
        small,
        at=(0.0, 0.3, 0.7, 1.0),
        A=rates * np.eye(7),
        B=small.B[four],
        C=small.C[four],
        D=small.D[four],
    )
    with pytest.raises(
        ValueError, match=r"model at = 0\.[345].*, between heights, grows by .* take more heights"
    ):
        steep.scheduled()
    with pytest.raises(ValueError, match=r"at = 1\.5 must be within 0 and 1"):
        linearise(find_case("rope-120"), [1.5])
    with pytest.raises(ValueError, match="outputs speed must be among rate"):
        models[0].selected(TORQUE, ["speed"])
    with pytest.raises(ValueError, match=r"outputs = 'rate' must be a list of names"):
        models[0].selected(TORQUE, "rate")


def test_ropes_that_differ_in_their_names_alone_are_equal_ones(tmp_path: Path) -> None:
    def model(ropes: str):
        (path := tmp_path / "hoist.toml").write_text(
            f'name = "hoist"\nlike = "rope-120"\n{ropes}', encoding="utf-8"
        )
        return linearise(read(path, HoistFile).case, [0.3])[0]

    place = "x_left = 0.2\nx_right = 0.2\nz = 0.5\nswivels.mode = "
    s = 2j * np.pi * np.array([0.1, 0.7])
    of_drive = [name for name in SEEN if "." not in name]
    of_rope = [*(name for name in SEEN if "." in name), "left.mx", "loop.z"]
    seen = [*of_drive, *of_rope]
    seen_of_b = [*of_drive, *(f"b.{name}" for name in of_rope)]
    for mode in ("locked", "free"):
        equal = model(f'[[rope]]\nnumber = 2\nswivels.mode = "{mode}"')
        apart = model("".join(f'[[rope]]\nname = "{name}"\n{place}"{mode}"\n' for name in "ab"))
        found = apart.selected((*TORQUE, "left.yaw"), seen_of_b).response(s)
        own = [*TORQUE, "left.x", "left.z"]
        if mode == "locked":
            own.append("left.yaw")
        torque, x, z, *yaw = np.moveaxis(equal.selected(own, seen).response(s), 2, 0)
        # what hangs beside the centre of a conveyance that yaws
        moved = 0.5 * x - 0.2 * z + sum(yaw)
        assert_allclose(
            np.moveaxis(found, 2, 0), (torque, moved), rtol=1e-6, atol=1e-9 * np.abs(found).max()
        )


@pytest.mark.usefixtures("plain_figures")
@pytest.mark.parametrize(
    ("command", "files"), [("modes", "modes.csv modes.png"), ("linearise", "plant.json plant.npz")]
)
def test_commands_write_their_files(command: str, files: str, draft: Path, tmp_path: Path) -> None:
    assert main([command, str(draft), "--at", "0.3", "--out", str(tmp_path)]) == 0
    assert all((tmp_path / name).stat().st_size > 0 for name in files.split())


@pytest.mark.parametrize(
    ("asked", "told"),
    [
        *(
            (f"modes --band {band}", f"--band {band} must be above 0.02 Hz")
            for band in ("-1", "0", "nan")
        ),
        ("modes --count 0", "--count 0 must be at least 1"),
        # two states of each motion, and one of the torque's lag: both counts are of one model
        ("linearise --at 0.5 --states 2", "states = 2 must be within 3 and "),
        ("linearise --at 0.2 0.5 --states 500", "states = 500 must be at most "),
    ],
)
def test_a_number_that_cannot_be_is_refused(
    asked: str, told: str, draft: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    command, *options = asked.split()
    assert main([command, str(draft), *options]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.parametrize("command", ["modes", "linearise"])
def test_linear_models_have_the_level_of_the_hoist(
    command: str, draft: Path, tmp_path: Path, monkeypatch: Patch
) -> None:
    seen = list[str]()

    def heard(case: Case, swivels: str, level: str) -> None:
        seen.append(level)
        raise ValueError("enough")

    monkeypatch.setattr(linearise_module, "_rope_specs", heard)
    assert main([command, str(draft), "--at", "0", "--out", str(tmp_path / "out")]) == 2
    assert seen == ["draft"]
