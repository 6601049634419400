"""What may be written over: only what is of the very kind that is to be written, and ours.

A verb names its outputs here before its work begins: where each goes and what it will be. What a
file is says its content, never its name. Past all that leads `--force` alone; and no force writes
two outputs to one place, or one over what the verb reads.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path

from cgagen.errors import FolderError, SamePlaceError, StorageError
from cgagen.inputs import start_of
from cgagen.places import Place, place_of
from cgagen.shown import short

HEAD_BYTES = 64 << 10
"""Of a file, what says its kind. Choice: images are whole in it."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of output.

    Attributes:
        what: it is, for sentences: "a waveform".
        is_ours: whether a file that begins so is one of ours, of this kind.
        precious: none is written over, not even one of ours.
    """

    what: str
    is_ours: Callable[[bytes], bool]
    precious: bool = False


def begins(what: str, *starts: str) -> Kind:
    """Return a kind whose files begin with one of some texts.

    >>> begins("a map", "line,").is_ours(b"line,column")
    True
    """
    return Kind(what, lambda head: head.startswith(tuple(start.encode() for start in starts)))


def never(what: str) -> Kind:
    """Return a kind of which nothing is written over: it cannot be made again."""
    return Kind(what, lambda _head: False, precious=True)


def check_outputs(
    outputs: Iterable[tuple[Path, Kind]], inputs: Iterable[Path] = (), force: bool = False
) -> list[Place]:
    """Refuse outputs that nothing can be written to, or that would cost something of the user's.

    Args:
        outputs: where each goes, and of which kind it is.
        inputs: what the verb reads; what is not there does no harm.
        force: files that are none of ours, or of another kind, may be written over.

    Returns:
        The places, in the order of the outputs.

    Raises:
        FolderError: something else stands there.
        SamePlaceError: two outputs, or an output and an input, are one file.
        StorageError: nothing can be written there.
    """
    named = [(place_of(path), kind) for path, kind in outputs]
    taken = {_identity(path): f"{short(str(path), 300)} is read" for path in inputs}
    taken.pop(None, None)
    for place, _ in named:
        identity = place.identity
        if identity is not None and identity in taken:
            raise SamePlaceError(
                f"{short(str(place.path), 300)}: {taken[identity]} in the same call; "
                "choose another name"
            )
        taken[identity] = f"{short(str(place.path), 300)} is written"
        taken.pop(None, None)
    for place, kind in named:
        if not force:
            _refuse_other(place, kind)
    return [place for place, _ in named]


def _identity(path: Path) -> tuple[object, ...] | None:
    try:
        place = place_of(path)
    except StorageError:
        return None
    return place.identity if place.status is not None else None


def _refuse_other(place: Place, kind: Kind) -> None:
    """Refuse to write over a file that is not of the kind."""
    if place.file is None or place.status is None or not place.status.st_size:
        return
    head = start_of(place.file, HEAD_BYTES)
    if head is None or not kind.is_ours(head):
        also = "" if kind.precious else f", and is not {kind.what} of cgagen's"
        raise FolderError(
            f"{short(str(place.path), 300)}: is there already{also}; choose another name, or "
            "give --force"
        )
