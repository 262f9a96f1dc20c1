"""The programs of an installed wheel. This is no part of the package cpinn, so that a program starts
without numpy."""
import os
import sys


def run():
    """Become the program by whose name this was started."""
    name = os.path.basename(sys.argv[0])
    path = os.path.join(os.path.dirname(os.path.abspath(__file__)), "cpinn", "bin", name)
    os.execv(path, [path, *sys.argv[1:]])
