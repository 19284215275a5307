"""Power cuts at random moments, with a drive that loses data that was not flushed."""

from bed import power_cuts
from bed.registry import vm_test

_CUTS = 100


@vm_test("full")
def power_cuts_alone():
    """Jobs of every kind and 100 power cuts at random moments, each with a random part of the unflushed data lost:
    everything that was reported is true, no job is lost or duplicated, and the running print is reported as
    interrupted."""
    return power_cuts.run("alone", _CUTS)


@vm_test("full")
def power_cuts_among_others():
    """100 power cuts while another program keeps synchronizing the file system, so that every intermediate state reaches
    the disk."""
    return power_cuts.run("among-others", _CUTS)
