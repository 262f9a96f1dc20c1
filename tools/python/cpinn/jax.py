"""Trained models as functions of JAX: values and gradients by the library's own derivatives.

    import cpinn.jax
    value = cpinn.jax.function(cpinn.open("runs/arm"), "x z")
    jax.jacfwd(value)(0.3, 0.2)             # exact; also under jit and vmap

In doubles where JAX has them: jax.config.update("jax_enable_x64", True).
"""
from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional

import jax
import numpy

from ._family import Family
from ._given import Numbers
from ._model import Model

__all__ = ["family_function", "function"]


def _called(call: Callable[..., Any], shape: tuple[int, ...], *given: Any) -> Any:
    dtype = jax.numpy.result_type(float)
    like: Any = jax.ShapeDtypeStruct(shape, dtype)  # type: ignore[no-untyped-call, unused-ignore]
    return jax.pure_callback(lambda *at: numpy.asarray(call(*map(numpy.asarray, at)), dtype), like,
                             *given, vmap_method="broadcast_all")


def _function(model: Model, columns: tuple[str, ...]) -> Callable[..., Any]:
    @jax.custom_jvp
    def value(s: Any, t: Any) -> Any:
        return _called(lambda s, t: numpy.stack(
            list(model.evaluate(" ".join(columns), s, t).values()), axis=-1),
            (*numpy.shape(s), len(columns)), s, t)

    @value.defjvp
    def change(at: Any, along: Any) -> Any:
        slopes = [_function(model, model.differentiated(columns, c))(*at) * dx[..., None]
                  for c, dx in zip("st" if model.in_motion else "s", along)]
        return value(*at), sum(slopes)

    return value


def function(model: Model, names: str) -> Callable[..., Any]:
    """Columns of a model, as `Model.evaluate` names them, as a function of s (m) and t (s): shape
    (..., columns). It can be differentiated up to the fourth order of the model."""
    value = _function(model, tuple(model.units(names)))
    return lambda s, t=0.0: value(*jax.numpy.broadcast_arrays(
        *(jax.numpy.asarray(x, float) for x in (s, t))))


def family_function(family: Family, s: Optional[Numbers] = None,
                    t: Numbers = 0.0) -> Callable[[Any], Any]:
    """Shapes (members, points, columns) of a family at places s (m, ascending; of `Members` those of
    its making), as a function of parameters (members, parameters), with its gradient. Not under
    vmap: members are the batch."""
    width = family.evaluate(numpy.zeros((0, len(family.ranges))), s, t).values.shape[1:]

    @jax.custom_jvp
    def value(at: Any) -> Any:
        return _called(lambda at: family.evaluate(at, s, t).values, (len(at), *width), at)

    @value.defjvp
    def change(at: Any, along: Any) -> Any:
        slopes = _called(lambda at: family.jacobian(at, s, t).jacobian,
                         (len(at[0]), *width, len(family.ranges)), at[0])
        return value(*at), jax.numpy.einsum("mpck,mk->mpc", slopes, along[0])

    return value
