"""The rights of the hostile programs."""

import os


def become_member(rights):
    """Becomes the user of "USER,GROUP", with that group in addition to the user's own. Does nothing if `rights` is empty."""
    if not rights:
        return
    user, group = map(int, rights.split(","))
    os.setgroups([group])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)
