"""Trained models as functions of PyTorch: values and gradients by the library's own derivatives.

    import cpinn.torch
    value = cpinn.torch.function(cpinn.open("runs/arm"), "x z")
    s = torch.linspace(0, 0.3, 11, dtype=torch.float64, requires_grad=True)
    value(s, torch.tensor(0.2)).sum().backward()             # s.grad, exact
"""
from __future__ import annotations

from collections.abc import Callable
from typing import Any, Optional

import numpy
import torch

from ._family import Family
from ._given import Numbers
from ._model import Model

__all__ = ["family_function", "function"]


class _Value(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
    """Columns at points; their derivatives are such values again, so that there are higher ones."""

    @staticmethod
    def forward(ctx: Any, model: Model, columns: tuple[str, ...], s: Any, t: Any) -> Any:
        ctx.model, ctx.columns = model, columns
        ctx.save_for_backward(s, t)
        found = model.evaluate(" ".join(columns), s.detach().numpy(), t.detach().numpy())
        return torch.from_numpy(numpy.stack(list(found.values()), axis=-1)).to(s.dtype)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> Any:
        s, t = ctx.saved_tensors
        by = [(gradients[0] * _Value.apply(ctx.model, ctx.model.differentiated(ctx.columns, c), s,
                                           t)).sum(-1) if wanted else None
              for c, wanted in zip("st", ctx.needs_input_grad[2:])]
        return (None, None, *by)


def function(model: Model, names: str) -> Callable[..., Any]:
    """Columns of a model, as `Model.evaluate` names them, as a function of tensors s (m) and t (s):
    shape (..., columns). It can be differentiated up to the fourth order of the model."""
    columns = tuple(model.units(names))

    def value(s: Any, t: Any = 0.0) -> Any:
        s = torch.as_tensor(s)
        t = torch.as_tensor(t, dtype=s.dtype)
        shape = numpy.broadcast_shapes(s.shape, t.shape)
        return _Value.apply(model, columns, s.expand(shape), t.expand(shape))

    return value


class _Shapes(torch.autograd.Function):  # type: ignore[misc, unused-ignore]
    @staticmethod
    def forward(ctx: Any, family: Family, s: Any, t: Any, at: Any) -> Any:
        found = family.jacobian(at.detach().numpy(), s, t)
        ctx.save_for_backward(torch.from_numpy(found.jacobian).to(at.dtype))
        return torch.from_numpy(found.values).to(at.dtype)

    @staticmethod
    def backward(ctx: Any, *gradients: Any) -> Any:
        return None, None, None, torch.einsum("mpc,mpck->mk", gradients[0], *ctx.saved_tensors)


def family_function(family: Family, s: Optional[Numbers] = None,
                    t: Numbers = 0.0) -> Callable[[Any], Any]:
    """Shapes (members, points, columns) of a family at places s (m, ascending; of `Members` those of
    its making), as a function of a tensor of parameters (members, parameters), with its gradient."""
    return lambda at: _Shapes.apply(family, s, t, at)
