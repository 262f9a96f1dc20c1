"""The C library by ctypes: its functions, its structures and its errors."""
from __future__ import annotations

import ctypes
from typing import Any

import numpy
import numpy.typing

from ._place import load

Array = numpy.typing.NDArray[numpy.float64]


class Error(Exception):
    """What is wrong, and what is allowed, in one line. All errors of the package are one.

    The classes below are also what a Python user expects: a wrong value is a `ValueError`, an
    argument of a wrong type a `TypeError`, a file that cannot be read or written an `OSError`, and
    numbers that end in no number an `ArithmeticError`.
    """


class InputError(Error, ValueError):
    """A scene, a file's content or an argument is not allowed."""


class ArgumentTypeError(Error, TypeError):
    """An argument has the wrong type."""


class FileError(Error, OSError):
    """A file cannot be read or written."""


class NotFiniteError(Error, ArithmeticError):
    """A computation has ended in numbers that are not finite."""


class OutOfMemoryError(Error, MemoryError):
    """Memory has run out."""


for _class in (Error, InputError, ArgumentTypeError, FileError, NotFiniteError, OutOfMemoryError):
    _class.__module__ = "cpinn"  # where users find them

# The rows of AD_STATUS_LIST, autodiff/error.h.
_CLASSES = {1: OutOfMemoryError, 2: InputError, 3: InputError, 5: NotFiniteError, 6: InputError,
            7: FileError, 10: FileError}


LIBRARY = load()


# ---- structures: tools/library/cpinn.h ----------------------------------------------------------

class ErrorText(ctypes.Structure):
    _fields_ = [("status", ctypes.c_int), ("message", ctypes.c_char * 512)]


class ProgressNow(ctypes.Structure):
    _fields_ = [("step", ctypes.c_int64), ("window", ctypes.c_int), ("windows", ctypes.c_int),
                ("stage", ctypes.c_int), ("stages", ctypes.c_int),
                ("load_factor", ctypes.c_double), ("loss", ctypes.c_double),
                ("held_out", ctypes.c_double), ("error", ctypes.c_double),
                ("seconds", ctypes.c_double)]


PROGRESS = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.POINTER(ProgressNow))


class TrainOptions(ctypes.Structure):
    _fields_ = [("threads", ctypes.c_int), ("folder", ctypes.c_char_p), ("resume", ctypes.c_bool),
                ("progress", PROGRESS), ("context", ctypes.c_void_p)]


class SolveOptions(ctypes.Structure):
    _fields_ = [("tolerance", ctypes.c_double), ("perturbation", ctypes.c_double),
                ("branch", ctypes.c_int)]


class EquationsCoordinate(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("unit", ctypes.c_char_p), ("low", ctypes.c_double),
                ("high", ctypes.c_double), ("periodic", ctypes.c_bool), ("time", ctypes.c_bool)]


class FitNow(ctypes.Structure):
    _fields_ = [("attempt", ctypes.c_int), ("window", ctypes.c_int), ("done", ctypes.c_double),
                ("estimate", ctypes.c_double), ("seconds", ctypes.c_double),
                ("patches", ctypes.c_int)]


FIT_PROGRESS = ctypes.CFUNCTYPE(ctypes.c_bool, ctypes.c_void_p, ctypes.POINTER(FitNow))


class FitOptions(ctypes.Structure):
    _fields_ = [("tolerance", ctypes.c_double), ("seconds", ctypes.c_double),
                ("threads", ctypes.c_int), ("progress", FIT_PROGRESS),
                ("context", ctypes.c_void_p)]


class FitSummary(ctypes.Structure):
    _fields_ = [("end", ctypes.c_int), ("estimate", ctypes.c_double),
                ("by_unknowns", ctypes.c_double), ("done", ctypes.c_double),
                ("seconds", ctypes.c_double), ("attempts", ctypes.c_int),
                ("windows", ctypes.c_int), ("most_patches", ctypes.c_int),
                ("parameters", ctypes.c_size_t), ("steps", ctypes.c_int),
                ("unknowns", ctypes.c_int), ("unknown", ctypes.c_double * 8),
                ("deviation", ctypes.c_double * 8)]


class FamilySettings(ctypes.Structure):
    _fields_ = [("extrapolate", ctypes.c_bool), ("threads", ctypes.c_int),
                ("points", ctypes.c_size_t), ("s", ctypes.c_void_p), ("t", ctypes.c_void_p),
                ("compile", ctypes.c_bool), ("ranks", ctypes.c_void_p),
                ("forces", ctypes.c_bool)]


class Polish(ctypes.Structure):
    _fields_ = [("steps", ctypes.c_int), ("alone", ctypes.c_bool), ("quick", ctypes.c_bool)]


class ReachSettings(ctypes.Structure):
    _fields_ = [("fixed", ctypes.c_void_p), ("tolerance", ctypes.c_double),
                ("seed", ctypes.c_uint64)]


class Parameter(ctypes.Structure):
    _fields_ = [("name", ctypes.c_char_p), ("low", ctypes.c_double), ("high", ctypes.c_double),
                ("scale", ctypes.c_int)]


# ---- calls ---------------------------------------------------------------------------------------

def call(function: Any, *arguments: Any) -> None:
    """Call a function whose last argument is an error, which is raised if there is one."""
    error = ErrorText()
    status = function(*arguments, ctypes.byref(error))
    if status != 0:
        raise _CLASSES.get(status, Error)(error.message.decode(errors="replace"))


class Made:
    """What the library has made: freed when nobody has it any more, and never copied."""

    def __init__(self, free: Any, function: Any, *arguments: Any) -> None:
        self._as_parameter_, self._free = ctypes.c_void_p(), free
        call(function, *arguments, ctypes.byref(self._as_parameter_))

    @classmethod
    def from_param(cls, made: Any) -> Any:
        """As an argument: ctypes would take a text or a number for a pointer."""
        if not isinstance(made, cls):
            raise ArgumentTypeError(f"{made!r}: is nothing that the library has made; models and "
                                    "solutions are made by cpinn.open, cpinn.train, cpinn.solve, "
                                    "cpinn.identify")
        return made._as_parameter_

    def __reduce_ex__(self, protocol: Any) -> Any:
        raise ArgumentTypeError(
            "what the C library has made lives in the memory of this process and cannot be copied "
            "or pickled; send the path of its file or folder, and open that there")

    def __del__(self) -> None:
        self._free(self._as_parameter_)


# ---- functions ----------------------------------------------------------------------------------

def declare(name: str, result: Any, *arguments: Any) -> Any:
    function = getattr(LIBRARY, name)
    function.restype, function.argtypes = result, arguments
    return function


P, I, D, S, Z, B = (ctypes.c_void_p, ctypes.c_int, ctypes.c_double, ctypes.c_char_p,
                    ctypes.c_size_t, ctypes.c_bool)
TEXTS, OUT, FAIL = ctypes.POINTER(S), ctypes.POINTER(P), ctypes.POINTER(ErrorText)

library_version = declare("cpinn_version", S)
train_file = declare("cpinn_train_file", I, S, I, TEXTS, ctypes.POINTER(TrainOptions), OUT, FAIL)
open_model = declare("cpinn_open", I, S, OUT, FAIL)
save = declare("cpinn_save", I, Made, S, FAIL)
free_model = declare("cpinn_free", None, P)
model_verdict = declare("cpinn_verdict", P, Made)
model_estimate = declare("cpinn_estimate", D, Made)
history_rows = declare("cpinn_history_rows", Z, Made)
history_columns = declare("cpinn_history_columns", I, Made)
history_name = declare("cpinn_history_name", S, Made, I)
history_value = declare("cpinn_history_value", D, Made, Z, S)
create_evaluator = declare("cpinn_evaluator", I, Made, S, OUT, FAIL)
evaluator_free = declare("evaluator_free", None, P)
evaluator_columns = declare("evaluator_columns", I, Made)
evaluator_name = declare("evaluator_column_name", S, Made, I)
evaluator_unit = declare("evaluator_column_unit", S, Made, I)
evaluator_evaluate = declare("evaluator_evaluate", I, Made, Z, P, P, P, FAIL)
solve_file = declare("cpinn_solve_file", I, S, I, TEXTS, ctypes.POINTER(SolveOptions), Z, P, OUT,
                     FAIL)
solution_free = declare("cpinn_solution_free", None, P)
solution_verdict = declare("cpinn_solution_verdict", P, Made)
solution_estimate = declare("cpinn_solution_estimate", D, Made)
solution_columns = declare("cpinn_solution_columns", I, Made)
solution_name = declare("cpinn_solution_column_name", S, Made, I)
solution_evaluate = declare("cpinn_solution_evaluate", I, Made, Z, P, P, P, FAIL)
equations_create = declare("equations_create", P)
equations_free = declare("equations_free", None, P)
equations_add_coordinate = declare("equations_add_coordinate", I, Made,
                                   ctypes.POINTER(EquationsCoordinate), FAIL)
equations_add_parameter = declare("equations_add_parameter", I, Made, S, S, FAIL)
equations_add_range = declare("equations_add_range", I, Made, S, D, D, FAIL)
equations_add_unknown = declare("equations_add_unknown", I, Made, S, D, FAIL)
equations_add_field = declare("equations_add_field", I, Made, S, FAIL)
equations_add_inside = declare("equations_add_inside", I, Made, S, FAIL)
equations_add_condition = declare("equations_add_condition", I, Made, S, D, S, S, FAIL)
equations_add_data = declare("equations_add_data", I, Made, Z, I, TEXTS, ctypes.POINTER(P), D, FAIL)
fit_equations = declare("cpinn_fit_equations", I, Made, ctypes.POINTER(FitOptions), OUT, FAIL)
fit_file = declare("cpinn_fit_file", I, S, I, TEXTS, ctypes.POINTER(FitOptions), OUT, FAIL)
fit_save = declare("cpinn_fit_save", I, Made, S, FAIL)
fit_open = declare("cpinn_fit_open", I, S, OUT, FAIL)
fit_free = declare("cpinn_fit_free", None, P)
fit_verdict = declare("cpinn_fit_verdict", P, Made)
fit_summary = declare("cpinn_fit_summary", FitSummary, Made)
fit_coordinate = declare("cpinn_fit_coordinate", S, Made, I)
fit_field = declare("cpinn_fit_field", S, Made, I)
fit_unknown = declare("cpinn_fit_unknown", S, Made, I)
fit_evaluate = declare("cpinn_fit_evaluate", I, Made, S, Z, ctypes.POINTER(P), P, P, FAIL)
family_not_compiled = declare("cpinn_family_not_compiled", S, Made)
family_open = declare("cpinn_family_open", I, S, P, OUT, FAIL)
family_file = declare("cpinn_family_file", I, S, I, TEXTS, D, P, OUT, FAIL)
family_free = declare("cpinn_family_free", None, P)
family_parameters = declare("cpinn_family_parameters", I, Made)
family_parameter = declare("cpinn_family_parameter", ctypes.POINTER(Parameter), Made, I)
family_columns = declare("cpinn_family_columns", I, Made)
family_name = declare("cpinn_family_column_name", S, Made, I)
family_evaluate = declare("cpinn_family_evaluate", I, Made, P, Z, P, P, P, FAIL)
family_jacobian = declare("cpinn_family_jacobian", I, Made, Z, P, P, P, P, FAIL)
reach = declare("cpinn_reach", I, Made, P, Z, P, P, P, FAIL)
identify_file = declare("cpinn_identify_file", I, S, I, TEXTS, I, OUT, FAIL)
unknowns_free = declare("cpinn_unknowns_free", None, P)
unknowns_count = declare("cpinn_unknowns_count", I, Made)
unknowns_name = declare("cpinn_unknowns_name", S, Made, I)
unknowns_value = declare("cpinn_unknowns_value", D, Made, I)
unknowns_deviation = declare("cpinn_unknowns_deviation", D, Made, I)
unknowns_correlation = declare("cpinn_unknowns_correlation", D, Made, I, I)
unknowns_chi_squared = declare("cpinn_unknowns_chi_squared", D, Made)
unknowns_freedom = declare("cpinn_unknowns_freedom", D, Made)
unknowns_verdict = declare("cpinn_unknowns_verdict", P, Made)
stepper_open = declare("cpinn_stepper_open", I, S, I, OUT, FAIL)
stepper_file = declare("cpinn_stepper_file", I, S, I, TEXTS, D, I, OUT, FAIL)
stepper_free = declare("cpinn_stepper_free", None, P)
stepper_states = declare("cpinn_stepper_states", I, Made)
stepper_inputs = declare("cpinn_stepper_inputs", I, Made)
stepper_input = declare("cpinn_stepper_input", ctypes.POINTER(Parameter), Made, I)
stepper_is_slow = declare("cpinn_stepper_is_slow", B, Made, I)
stepper_ramps = declare("cpinn_stepper_ramps", B, Made)
stepper_step = declare("cpinn_stepper_step", D, Made)
stepper_length = declare("cpinn_stepper_length", D, Made)
stepper_advance = declare("cpinn_stepper_advance", I, Made, Z, P, P, P, P, P, P, FAIL)
stepper_tip = declare("cpinn_stepper_tip", None, Made, Z, P, P)
stepper_rest = declare("cpinn_stepper_rest", None, Made, Z, P, P)
reason_word = declare("cpinn_reason_word", S, I)
source_word = declare("cpinn_source_word", S, I)
outcome_of = declare("verdict_outcome_of", I, P)
outcome_name = declare("verdict_outcome_name", S, I)
worst_reason = declare("verdict_worst", I, P)
reason_name = declare("verdict_reason_name", S, I)
verdict_text = declare("verdict_text", S, P)
