"""The proof of `hil.proof`, with the lines of the source where it is the image's, and made once."""

from cgagen.errors import SourceError
from hil.evidence import Evidence
from hil.proof import Proof, prove
from hil.registers import Compile
from hil.stimuli import SEED
from hil.subject import Subject


def proof_of(
    subject: Subject, compile_source: Compile, count: int | None = None, seed: int = SEED
) -> Proof:
    """Put cells of the sensor space to the image; a reason names its line where there is one.

    Args:
        subject: what is on trial.
        compile_source: the tokenizer.
        count: how many cells, drawn by chance; None for all.
        seed: of the drawing.
    """
    try:
        compiled = compile_source(subject.sources["main"], subject.files["main"])
        same = compiled.image.eeprom == subject.images["main"].eeprom
    except SourceError:
        same = False
    return prove(subject, count, seed, compiled.source_map if same else None)


def whole_proof(evidence: Evidence, compile_source: Compile) -> Proof:
    """Return the proof over all cells of a firmware, made where nobody has asked for it before."""
    if evidence.whole is None:
        evidence.whole = proof_of(evidence.subject, compile_source)
    evidence.proof(evidence.whole)
    return evidence.whole
