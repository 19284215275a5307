"""The power fails at a chance moment, and the drive has not what was not flushed."""

from bed import power_cuts
from bed.registry import vm_test

_CUTS = 100


@vm_test("full")
def power_cuts_alone():
    """Jobs of every kind, and the power cut at 100 chance moments, with any part of what was not flushed lost: whatever
    was told is so, no job is lost or there twice, and what was printing is told as interrupted."""
    return power_cuts.run("alone", _CUTS)


@vm_test("full")
def power_cuts_among_others():
    """The same 100 times where another program synchronizes the file system all the time, so that every state in
    between reaches the disk."""
    return power_cuts.run("among-others", _CUTS)
