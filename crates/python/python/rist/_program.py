"""The command `rist`: the program, which the extension holds beside the library."""

import signal
import sys

from ._rist import _run_program


def main() -> int:
    """Runs the program with the words of the command line, and returns its exit code."""
    # The handler of Python waits for the interpreter, which does not run meanwhile: the program has its own. A shell's job in
    # the background goes on ignoring the signal.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _run_program(["rist", *sys.argv[1:]])
