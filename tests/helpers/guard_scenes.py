"""A rope whose loop is guarded."""

from dataclasses import replace

from rope_model import (
    Guard,
    Mesh,
    Rope,
    Scene,
)

SHORT = Scene(Rope(length=30.0), mesh=Mesh("eem", elements=16))


def guarded(guard: Guard, scene: Scene = SHORT) -> Scene:
    return scene.with_(shaft=replace(scene.shaft, guard=guard))
