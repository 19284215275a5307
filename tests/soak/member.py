"""The rights of the hostile programs."""

import os


def become_member(rights):
    """ "USER,GROUP": that user from now on, with that group besides his own. Nothing where there is but one user."""
    if not rights:
        return
    user, group = map(int, rights.split(","))
    os.setgroups([group])
    os.setresgid(user, user, user)
    os.setresuid(user, user, user)
