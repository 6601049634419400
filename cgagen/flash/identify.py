"""Who is there: each model is called by its own challenge after a reset of its own."""

from collections import Counter
from collections.abc import Iterable

from cgagen.flash.modules import Calling, Module, callings_from, module_of
from cgagen.flash.requests import (
    Conversation,
    Enter,
    Hear,
    Heard,
    Symptom,
    TroubleError,
    exchange,
)
from cgagen.stamp.chips import Chip, chip

REPLY_MS = 200
"""How long a module may take to answer a challenge. Ref: S17."""

QUIET_MS = 20
"""How long nothing may follow an answer; a second echo would. Choice: 20 bytes' time."""

ROUNDS = 2
"""How often all models are called before nobody is there. Choice: once more than needed."""

OURS = (chip("BS2"), chip("BS2p"))
"""What is called first where nothing is expected: the robots' own controllers. Choice."""

BREAK_ECHO = 0x00
"""What comes back of a BREAK, as of a byte without a stop bit. Choice: FIDELITY.md."""

_WITHOUT_LOADER = (Symptom.STRAY, Symptom.WRONG_ANSWER, Symptom.NO_ANSWER)
"""What is met, too, where no loader listens because BREAK did not get there. (Who talks all the
time hides the echo of BREAK.)"""

_MOST_TELLING = tuple(Symptom)


def identify(likely: Iterable[Chip] = OURS, rounds: int = ROUNDS) -> Conversation[Module]:
    """Return the module on the line; it is in its loader then and awaits slot or packets.

    Args:
        likely: the models that are called first.
        rounds: how often all are called.

    Raises:
        TroubleError: nobody answers; the symptom is what was met most often.
    """
    callings = callings_from(likely)
    met: list[TroubleError] = []
    for _ in range(rounds):
        met = []
        for calling in callings:
            try:
                return (yield from call(calling))
            except TroubleError as trouble:
                if trouble.symptom is Symptom.DOUBLE_ECHO:
                    # One byte can double by chance; a second echo at every byte would make
                    # other models of nobody, for some answer with the challenge itself.
                    return (yield from call(calling))
                met.append(trouble)
    raise _verdict(met)


def call(calling: Calling) -> Conversation[Module]:
    """Call one model.

    Raises:
        TroubleError: it does not answer as it should.
    """
    heard = yield Enter()
    try:
        return (yield from _greet(calling, heard))
    except TroubleError as trouble:
        if BREAK_ECHO in heard.after or trouble.symptom not in _WITHOUT_LOADER:
            raise
        raise TroubleError(Symptom.NO_BREAK, str(trouble)) from trouble


def _greet(calling: Calling, heard: Heard) -> Conversation[Module]:
    if heard.before:
        raise TroubleError(Symptom.TALKING, f"{heard.before[-8:].hex(' ')}h")
    for challenge, answer in calling.greeting:
        reply = yield from _ask(challenge)
        if reply == challenge:
            raise TroubleError(Symptom.DOUBLE_ECHO, f"{reply:02x}h")
        if reply != answer:
            raise _wrong(challenge, reply)
    reply = yield from _ask(calling.version)
    module = module_of(calling, reply)
    if module is None:
        raise _wrong(calling.version, reply)
    late = yield Hear(QUIET_MS)
    if late.after:
        raise TroubleError(Symptom.STRAY, f"{late.after.hex(' ')}h behind {reply:02x}h")
    return module


def _ask(challenge: int) -> Conversation[int]:
    reply = yield from exchange(bytes((challenge,)), 1, REPLY_MS)
    return reply[0]


def _wrong(challenge: int, reply: int) -> TroubleError:
    return TroubleError(Symptom.WRONG_ANSWER, f"{reply:02x}h to {challenge:02x}h")


def _verdict(met: list[TroubleError]) -> TroubleError:
    """Return the trouble that stands for all: what babbles first, then what was met most."""
    counts = Counter(trouble.symptom for trouble in met)
    if counts[Symptom.TALKING]:
        wanted = Symptom.TALKING
    else:
        wanted = max(counts, key=lambda one: (counts[one], -_MOST_TELLING.index(one)))
    return next(trouble for trouble in met if trouble.symptom is wanted)
