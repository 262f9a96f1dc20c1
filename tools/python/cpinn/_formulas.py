"""Formulas of equations: numbers and names with operators. They are texts that the C library reads,
so Python does nothing while equations are solved."""
from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Optional

import numpy

from ._library import ArgumentTypeError, InputError

if TYPE_CHECKING:
    from ._equations import Equations

pi = math.pi

# How tightly the outermost operator of a text binds.
_SUM, _PRODUCT, _POWER, _WHOLE = range(4)


class Formula:
    """A formula of coordinates, parameters and fields: operators ``+ - * / **`` and functions as
    `cpinn.sin` make it; ``str()`` is its text."""

    __array_ufunc__ = None  # numpy's numbers leave operators to this class

    def __init__(self, text: str, binds: int = _WHOLE, of: Optional["Equations"] = None) -> None:
        self.text, self.binds, self.of = text, binds, of

    def __str__(self) -> str:
        return self.text

    def __repr__(self) -> str:
        return f"<cpinn.Formula: {self.text}>"

    def d(self, coordinate: "Formula", order: int = 1) -> "Formula":
        """The derivative by a coordinate, `order` times."""
        if self.of is None:
            raise InputError(f"({self}).d: is a number; allowed: formulas of names")
        return self.of.formula(None, self).d(coordinate, order)

    def within(self, binds: int) -> str:
        """Its text as an operand of what binds so tightly."""
        return self.text if self.binds >= binds else f"({self.text})"

    def __add__(self, other: Any) -> "Formula":
        return _join(self, " + ", other, _SUM, _SUM)

    def __radd__(self, other: Any) -> "Formula":
        return _join(other, " + ", self, _SUM, _SUM)

    def __sub__(self, other: Any) -> "Formula":
        return _join(self, " - ", other, _SUM, _PRODUCT)

    def __rsub__(self, other: Any) -> "Formula":
        return _join(other, " - ", self, _SUM, _PRODUCT)

    def __mul__(self, other: Any) -> "Formula":
        return _join(self, "*", other, _PRODUCT, _PRODUCT)

    def __rmul__(self, other: Any) -> "Formula":
        return _join(other, "*", self, _PRODUCT, _PRODUCT)

    def __truediv__(self, other: Any) -> "Formula":
        return _join(self, "/", other, _PRODUCT, _POWER)

    def __rtruediv__(self, other: Any) -> "Formula":
        return _join(other, "/", self, _PRODUCT, _POWER)

    def __pow__(self, other: Any) -> "Formula":
        if isinstance(other, Formula):
            raise InputError(f"({self}) ** ({other}): the exponent is no number; allowed: numbers, and "
                             "exp(b*log(a)) for a ** b")
        return _join(self, "^", other, _WHOLE, _WHOLE, _POWER)

    def __neg__(self) -> "Formula":
        return Formula("-" + self.within(_PRODUCT), _SUM, self.of)

    def __pos__(self) -> "Formula":
        return self

    def __abs__(self) -> "Formula":
        return _call("abs", self)

    def __bool__(self) -> bool:
        raise ArgumentTypeError(f"({self}): is true or false nowhere; allowed: cpinn.where(a, b, c), "
                                "which is b where a > 0 and else c")


def formula_of(value: Any) -> Formula:
    """A formula, of numbers too."""
    if isinstance(value, Formula):
        return value
    try:
        number = float(value)
    except (TypeError, ValueError):
        raise ArgumentTypeError(f"{repr(value):.80}: is of type {type(value).__name__}; allowed: "
                                "numbers and formulas") from None
    if not math.isfinite(number):
        raise InputError(f"{number}: is in a formula; allowed: finite numbers")
    text = str(int(number)) if number.is_integer() and abs(number) < 1e15 else repr(number)
    return Formula(text, _WHOLE if number >= 0 else _SUM)


def _owner(*formulas: Formula) -> Optional["Equations"]:
    owner = None
    for formula in formulas:
        if formula.of is not None and owner is not None and formula.of is not owner:
            raise InputError(f"{formula}: is of other equations; allowed: names of the same ones")
        owner = formula.of if owner is None else owner
    return owner


def _join(a: Any, sign: str, b: Any, left: int, right: int, binds: Optional[int] = None) -> Formula:
    first, second = formula_of(a), formula_of(b)
    return Formula(first.within(left) + sign + second.within(right),
                   left if binds is None else binds, _owner(first, second))


def _call(name: str, *arguments: Any) -> Formula:
    formulas = [formula_of(argument) for argument in arguments]
    return Formula(f"{name}({', '.join(map(str, formulas))})", _WHOLE, _owner(*formulas))


def _function(name: str, of_numbers: Any) -> Any:
    def call(x: Any) -> Any:
        return _call(name, x) if isinstance(x, Formula) else of_numbers(x)
    call.__name__ = call.__qualname__ = name
    call.__doc__ = f"{name} of a formula, or of numbers as numpy has it."
    return call


sin, cos, tan = _function("sin", numpy.sin), _function("cos", numpy.cos), _function("tan", numpy.tan)
asin, acos, atan = (_function("asin", numpy.arcsin), _function("acos", numpy.arccos),
                    _function("atan", numpy.arctan))
sinh, cosh, tanh = (_function("sinh", numpy.sinh), _function("cosh", numpy.cosh),
                    _function("tanh", numpy.tanh))
exp, log, sqrt = _function("exp", numpy.exp), _function("log", numpy.log), _function("sqrt", numpy.sqrt)


def minimum(a: Any, b: Any) -> Formula:
    """The smaller one of two formulas."""
    return _call("min", a, b)


def maximum(a: Any, b: Any) -> Formula:
    """The larger one of two formulas."""
    return _call("max", a, b)


def where(condition: Any, a: Any, b: Any) -> Formula:
    """a where the condition is above 0, else b."""
    return _call("where", condition, a, b)
