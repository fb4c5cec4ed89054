"""Which names a piece of code looks up outside its functions."""

import dis
from types import CodeType

_READS = ("LOAD_GLOBAL", "LOAD_NAME")


def global_names(code: CodeType) -> set[str]:
    """The global names that code reads, its nested functions included."""
    found = {step.argval for step in dis.get_instructions(code) if step.opname in _READS}
    nested = [inner for inner in code.co_consts if isinstance(inner, CodeType)]
    return found.union(*map(global_names, nested))
