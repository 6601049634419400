"""What would be sent: an image as packets, in order, with what stays as it is on the chip."""

from dataclasses import dataclass

from cgagen.errors import ImageError
from cgagen.flash.modules import calling_of
from cgagen.stamp.image import SENT, Image, Use
from cgagen.stamp.packets import BLOCK_BYTES, packet

START_BLOCK = 127
"""It holds the program's start and goes last. Ref: S3."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A download.

    Attributes:
        image: what goes into the chip.
        blocks: the 16-byte blocks that are sent, ascending.
        packets: their packets.
    """

    image: Image
    blocks: tuple[int, ...]
    packets: tuple[bytes, ...]

    @property
    def seconds(self) -> float:
        """About how long the packets take: 19 bytes and some 10 ms of writing for each."""
        return len(self.packets) * (19 * 10 / 9600 + 0.010)

    def to_text(self) -> str:
        """Return what would be sent, for a reader."""
        model = self.image.model
        slot = f"slot byte {self.image.slot:02X}h" if calling_of(model).takes_slot else "no slot"
        first = self.blocks[0] * BLOCK_BYTES
        lines = [
            f"{model.name}: {slot}, {len(self.packets)} packets of 18 bytes, blocks "
            f"{_ranges(self.blocks)} of 128 (bytes {first} to 2047), about {self.seconds:.1f} s",
            f"image {self.image.digest}",
        ]
        lines += [data.hex(" ").upper() for data in self.packets]
        return "\n".join(lines)


def plan_of(image: Image) -> Plan:
    """Return the packets of an image: the blocks that its flags mark, or all where it has none.

    Raises:
        ImageError: the block with the program's start is not marked, or one that is not marked
            holds program or DATA.
    """
    if image.flags is None:
        blocks = tuple(range(START_BLOCK + 1))
    else:
        blocks = tuple(n for n in range(START_BLOCK + 1) if _marked(image.flags, n))
    if START_BLOCK not in blocks:
        raise ImageError(
            "the image's flags leave out the block with the start of its program; build it again"
        )
    return Plan(
        image,
        blocks,
        tuple(packet(n, image.eeprom[n * BLOCK_BYTES : (n + 1) * BLOCK_BYTES]) for n in blocks),
    )


def _marked(flags: bytes, block: int) -> bool:
    own = flags[block * BLOCK_BYTES : (block + 1) * BLOCK_BYTES]
    sent = {bool(flag & SENT) for flag in own}
    if len(sent) > 1:
        raise ImageError(f"half of block {block} is marked to be sent; build the image again")
    marked = sent.pop()
    if not marked and any(flag & 3 >= Use.DATA for flag in own):
        raise ImageError(
            f"block {block} holds program or DATA and is not marked to be sent; build it again"
        )
    return marked


def _ranges(blocks: tuple[int, ...]) -> str:
    """Return numbers as ranges.

    >>> _ranges((0, 1, 2, 7, 126, 127))
    '0-2, 7, 126-127'
    """
    return ", ".join(f"{a}" if a == b else f"{a}-{b}" for a, b in runs(blocks))


def runs(blocks: tuple[int, ...]) -> list[tuple[int, int]]:
    """Return neighbouring blocks as first and last of each run.

    >>> runs((0, 1, 2, 7, 126, 127))
    [(0, 2), (7, 7), (126, 127)]
    """
    found: list[tuple[int, int]] = []
    for block in blocks:
        if found and block == found[-1][1] + 1:
            found[-1] = (found[-1][0], block)
        else:
            found.append((block, block))
    return found
