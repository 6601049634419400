"""The condition of a port as far as it can be seen without opening it, which could reset a chip."""

import os
from typing import NamedTuple

from cgagen.errors import RigError
from cgagen.link.lock import PortLock
from cgagen.link.ports import PortInfo, all_ports
from cgagen.link.why import ABSENT, busy, holders, may_open, no_permission


class Condition(NamedTuple):
    """What was seen of a port.

    Attributes:
        port: which.
        ok: it could be used now.
        says: "free", or why it cannot be used and what to do.
    """

    port: PortInfo
    ok: bool
    says: str


def condition_of(port: PortInfo) -> Condition:
    """Look at a port: is it there, may this user open it, has somebody else got it."""
    if not os.path.exists(port.device):
        return Condition(port, False, ABSENT)
    if not may_open(port.device):
        return Condition(port, False, no_permission(port.device))
    lock = PortLock(port.device)
    try:
        lock.take()
    except RigError as error:
        return Condition(port, False, str(error).removeprefix(f"{port.device}: "))
    lock.release()
    others = holders(port.device)
    return Condition(port, False, busy(others)) if others else Condition(port, True, "free")


def all_conditions() -> tuple[Condition, ...]:
    """Look at all ports of this machine; opens none and resets nothing."""
    return tuple(condition_of(port) for port in all_ports())
