"""Symptoms as sentences: what was met, what it comes from most often, and what to do."""

from cgagen.flash.requests import Symptom, TroubleError

SENTENCES: dict[Symptom, str] = {
    Symptom.DOUBLE_ECHO: (
        "every byte comes back twice ({detail}), once from the Stamp's wiring and once from the "
        "adapter; switch the adapter's local echo off"
    ),
    Symptom.NO_BREAK: (
        "neither BREAK nor an answer of a loader comes back ({detail}); switch the Stamp on, "
        "take an adapter that carries BREAK, and look at the wire from DTR to ATN"
    ),
    Symptom.TALKING: (
        "something goes on talking through a reset ({detail}), so the reset does not reach the "
        "Stamp, or BREAK does not; look at the wire from DTR to ATN, and at the adapter, which "
        "must have DTR and BREAK"
    ),
    Symptom.WRONG_ECHO: (
        "another echo comes back than was sent ({detail}): noise, framing errors, a second talker, "
        "or wiring without echo; look at ground and cable, at SIN and SOUT, and whether the lines "
        "are inverted or of another speed"
    ),
    Symptom.STRAY: (
        "bytes come that nobody has asked for ({detail}); look for a second talker on the line, "
        "at ground and cable"
    ),
    Symptom.WRONG_ANSWER: (
        "an answer came that no Stamp gives ({detail}); look at ground and cable and at the wire "
        "from DTR to ATN, or this is no BASIC Stamp of a known model (the BS2px is none)"
    ),
    Symptom.NO_ANSWER: (
        "the echo comes back and no answer ({detail}): the wiring is right and the Stamp is "
        "silent; switch it on, and look at the wire from DTR to ATN"
    ),
    Symptom.NO_ECHO: (
        "nothing comes back, not even the echo ({detail}): no Stamp on this cable; look at the "
        "wires of SIN and SOUT and at ground"
    ),
    Symptom.REFUSED: (
        "the chip found {detail} broken again and again; look at ground and cable, or take a "
        "shorter one"
    ),
    Symptom.WORN: (
        "the chip's EEPROM does not take {detail}; look at the supply voltage, else the EEPROM "
        "is worn out and the module to be replaced"
    ),
    Symptom.FELL_SILENT: (
        "every packet was acknowledged, then the line fell silent ({detail}), and whether the "
        "program runs is not known; switch the Stamp on and reset it"
    ),
}
"""By symptom; `WRONG_MODEL` has a sentence of its own, because it names two models."""

WRONG_MODEL = (
    "this is a {detail}, the image is for a {wanted}; nothing was sent: choose the other port, or "
    "build for this model"
)

HALF = "; the chip holds half a program now: flash it again before it runs"
"""Behind every sentence about a download that had begun."""

UNSTARTED = (
    "{port}: lost ({error}) when every packet had been acknowledged and before the program was "
    "started; reset the Stamp, and look at the cable"
)

UNREAD = (
    "{error}; every packet had been acknowledged, and nothing of it could be read back: flash it "
    "again, or leave --verify out"
)


def sentence_of(trouble: TroubleError, port: str, wanted: str, begun: bool) -> str:
    """Return what a user reads.

    Args:
        trouble: what was met.
        port: where.
        wanted: the model of the image.
        begun: packets had been sent.

    >>> sentence_of(TroubleError(Symptom.WRONG_MODEL, "BS2"), "/dev/ttyUSB0", "BS2p", False)
    ... # doctest: +ELLIPSIS
    '/dev/ttyUSB0: this is a BS2, the image is for a BS2p; nothing was sent: ...'
    """
    if trouble.symptom is Symptom.WRONG_MODEL and begun:
        # Only after a failed attempt: somebody has changed modules on the bench.
        return f"{port}: a {trouble.detail} stands where a {wanted} stood{HALF}"
    text = SENTENCES.get(trouble.symptom, WRONG_MODEL)
    return f"{port}: {text.format(detail=trouble.detail, wanted=wanted)}{HALF if begun else ''}"
