"""Bytes of a saved state: a line with the rope's form and fixed parameters, and the state in that form.

A state belongs to the parameters that must not change during a run.  The others, those of
``retune``, are no part of it.
"""

import json
from collections.abc import Iterator

from rope_model.parameters import Scene
from rope_model.scene_names import NamedParameter, named_parameters

_MAGIC = b"balance rope state "
_SHOWN = 3  #: parameters in a message: the first lead to the cause


def changed_fixed_parameters(
    old: Scene, new: Scene
) -> Iterator[tuple[NamedParameter, NamedParameter]]:
    """Yield the parameters, old and new, that differ and must not change during a run."""
    for before, after in zip(named_parameters(old), named_parameters(new), strict=True):
        if before.value != after.value and not before.facts.tunable:
            yield before, after


def labelled(state: bytes, form: str, scene: Scene) -> bytes:
    """Return the state behind a line with the form and the fixed parameters of its rope."""
    fixed = {p.name: p.value for p in named_parameters(scene) if not p.facts.tunable}
    label = json.dumps({"form": form, "parameters": fixed})
    return b"".join((_MAGIC, label.encode(), b"\n", state))


def state_behind_label(data: bytes, form: str, scene: Scene) -> bytes:
    """Return the state that ``labelled`` was given; ValueError if it is not one of this rope."""
    line, _, state = data.partition(b"\n")
    try:
        if not line.startswith(_MAGIC):
            raise ValueError("they begin otherwise")
        label = json.loads(line.removeprefix(_MAGIC))
        saved_form = label["form"]
        there = dict(label["parameters"])
    except (KeyError, TypeError, ValueError) as error:
        raise ValueError(
            f"these {len(data)} bytes must be a saved state of a rope: give the result of save()"
        ) from error
    require_form(saved_form, form)
    here = {p.name: p.value for p in named_parameters(scene) if not p.facts.tunable}
    if there.keys() != here.keys():
        raise ValueError(
            "the saved state has the parameters of another version of rope_model: "
            "restore it with that version, or save it anew"
        )
    _require_same({name: (there[name], here[name]) for name in here if there[name] != here[name]})
    return state


def require_same_rope(saved: Scene, scene: Scene) -> None:
    """Raise ValueError if a state of a rope with the data ``saved`` does not belong to ``scene``."""
    if saved is not scene:
        changes = changed_fixed_parameters(saved, scene)
        _require_same({before.name: (before.value, after.value) for before, after in changes})


def require_form(saved: str, form: str) -> None:
    """Raise ValueError if a state of the form ``saved`` is none of this ``form``."""
    if saved != form:
        raise ValueError(
            f"this is a state of the {saved} rope and must be one of the {form} rope: "
            f"restore it into balance_rope(scene, {saved!r})"
        )


def _require_same(differences: dict[str, tuple[float, float]]) -> None:
    """Raise ValueError if there are differences, (saved, present) by the parameter's name."""
    if not differences:
        return
    shown = [
        f"{name} = {there!r} must be {here!r}"
        for name, (there, here) in list(differences.items())[:_SHOWN]
    ]
    if len(differences) > _SHOWN:
        shown.append(f"and {len(differences) - _SHOWN} more parameters differ")
    raise ValueError(
        f"this is a state of another rope: {', '.join(shown)}; "
        "restore it into a rope with the same parameters"
    )
