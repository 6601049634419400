"""The download: slot, packets one by one with their acknowledgements, and the safe end.

What a loader does after a packet that it did not like is nowhere documented. So whatever goes
wrong on the line, the whole begins again with a reset, which is; and no more than `ATTEMPTS`
times.
"""

from dataclasses import dataclass, field

from cgagen.flash.identify import QUIET_MS, REPLY_MS, identify
from cgagen.flash.modules import Module, calling_of
from cgagen.flash.plan import Plan
from cgagen.flash.requests import (
    Conversation,
    Hear,
    Progress,
    Restart,
    Say,
    Symptom,
    TroubleError,
    exchange,
)
from cgagen.stamp.packets import BLOCK_BYTES

ATTEMPTS = 3
"""Choice."""

PACKET_MS = 1_000
"""How long a packet's acknowledgement may take. Ref: S17."""

TAIL_MS = 50
"""How long nothing may follow the last acknowledgement: longer than a packet's writing takes, so
that an acknowledgement that was due to it cannot have been another's. Choice."""

START_MS = 300
"""How long the program has to say something before it is started by a reset. Choice."""

SIGN_OFF = 0x00
"""Ends the loader. Ref: S17, which sends it always; what it does is inferred."""

SIGN_OFFS = 2
"""How often it is sent while no echo comes. Choice."""

TAKEN, BROKEN, WORN = 0x00, 0x01, 0x02
"""Acknowledgements: taken, checksum or communication error, EEPROM error. Ref: S18."""


@dataclass(slots=True)
class State:
    """What became of the chip, for those who have to tell when something goes wrong.

    Attributes:
        attempt: from 1.
        begun: a packet has been sent, so the chip holds neither program whole.
        complete: every packet of one attempt has been acknowledged.
        worn: blocks that the EEPROM is said not to take.
    """

    attempt: int = 0
    begun: bool = False
    complete: bool = False
    worn: set[int] = field(default_factory=set)


@dataclass(frozen=True, slots=True)
class Done:
    """A download whose every packet has been acknowledged.

    Attributes:
        module: what it went into.
        talks: the program was heard after the sign-off; otherwise it was started by a reset.
    """

    module: Module
    talks: bool


def download(plan: Plan, state: State, attempts: int = ATTEMPTS) -> Conversation[Done]:
    """Send a plan and start the program.

    Raises:
        TroubleError: not every packet was acknowledged.
    """
    while True:
        state.attempt += 1
        try:
            module = yield from _send(plan, state)
            break
        except TroubleError as trouble:
            if trouble.final or state.attempt >= attempts:
                raise
    state.complete = True
    return Done(module, (yield from _start()))


def _send(plan: Plan, state: State) -> Conversation[Module]:
    """One attempt, from the reset to the last acknowledgement."""
    model = plan.image.model
    module = yield from identify((model,))
    if module.model is not model:
        raise TroubleError(Symptom.WRONG_MODEL, module.name, final=True)
    if calling_of(model).takes_slot:
        yield from exchange(bytes((plan.image.slot,)), 0, REPLY_MS)
        late = yield Hear(QUIET_MS)
        if late.after:
            same = late.after[0] == plan.image.slot
            symptom = Symptom.DOUBLE_ECHO if same else Symptom.STRAY
            raise TroubleError(symptom, f"{late.after.hex()}h behind the slot byte")
    for number, (block, data) in enumerate(zip(plan.blocks, plan.packets, strict=True)):
        state.begun = True
        reply = yield from exchange(data, 1, PACKET_MS)
        _judge(reply[0], block, state)
        yield Progress(number + 1, len(plan.packets), state.attempt)
    heard = yield Hear(TAIL_MS)
    if heard.after and heard.after[0] in (TAKEN, BROKEN, WORN):
        # One answer too many: none of them can be told from a doubled byte.
        raise TroubleError(Symptom.STRAY, f"{heard.after.hex()}h behind the last packet")
    return module


def _judge(reply: int, block: int, state: State) -> None:
    where = f"block {block} (bytes {block * BLOCK_BYTES} to {(block + 1) * BLOCK_BYTES - 1})"
    if reply == BROKEN:
        raise TroubleError(Symptom.REFUSED, where)
    if reply == WORN:
        # Nothing protects the acknowledgement itself, so one alone may be a bit of noise.
        again = block in state.worn
        state.worn.add(block)
        raise TroubleError(Symptom.WORN, where, final=again)
    if reply != TAKEN:
        raise TroubleError(Symptom.WRONG_ANSWER, f"{reply:02x}h for {where}")


def _start() -> Conversation[bool]:
    """End the loader, and make sure that the program runs.

    The program may talk over the echo, so nothing that comes is an error any more.

    Raises:
        TroubleError: nothing comes at all, not even an echo.
    """
    sign_off = bytes((SIGN_OFF,))
    for _ in range(SIGN_OFFS):
        heard = yield Say(sign_off, 0, REPLY_MS)
        if heard.before or (yield Hear(START_MS)).after:
            return True
        if heard.after:
            yield Restart()
            return False
    yield Restart()
    raise TroubleError(Symptom.FELL_SILENT, f"no echo of {sign_off.hex()}h", final=True)
