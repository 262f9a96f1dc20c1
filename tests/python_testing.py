"""What the tests of the Python package share. Exit status 77: skipped, without numpy."""
import sys

try:
    import numpy  # noqa: F401
except ImportError:
    sys.exit(77)
import cpinn

configs = sys.argv[1]

FAMILY = """parameters: {force: {range: [-0.03, 0.03]}}
rod: {model: kirchhoff, length: 0.3, section: {shape: circle, radius: 0.005},
      material: {youngs_modulus: 1.0e6, poissons_ratio: 0.45}}
boundary: {start: {type: clamped, rotation: [0, 1, 0, 1]}, end: {type: loaded}}
loads: {tip: {force: [0, 0, force]}}
"""


def raises(kind, text, function, *arguments, **named):
    """The error is one of cpinn, of this built-in kind, and says this text; and its words are not
    those of a command line."""
    try:
        function(*arguments, **named)
    except cpinn.Error as error:
        assert isinstance(error, kind), (type(error), str(error))
        assert text in str(error), str(error)
        for word in ("--set", "--out", "--resume", "--help", "--at", "exit"):
            assert word not in str(error), str(error)
    else:
        raise AssertionError(f"{text}: nothing was raised")
