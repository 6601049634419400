"""The packets that carry an image to the chip, and the way back.

A packet is 18 bytes: 80h plus the number of a 16-byte block, the block as it is, and a
checksum that makes all 18 sum to 0 modulo 256. Only blocks that hold a defined byte are sent;
the others keep what the chip holds. Ref: S3 (TModuleRec.PacketBuffer), rebuilt by our own code.
"""

from collections.abc import Iterable

from cgagen.errors import ImageError
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.image import Image, Use

BLOCK_BYTES = 16
PACKET_BYTES = 1 + BLOCK_BYTES + 1
_FIRST = 0x80


def packets_of(image: Image) -> tuple[bytes, ...]:
    """Return the packets of an image, blocks ascending.

    Raises:
        ImageError: the image has no flags, so what must be sent is not known.
    """
    flags = image.known_flags()
    return tuple(
        packet(start // BLOCK_BYTES, image.eeprom[start : start + BLOCK_BYTES])
        for start in range(0, EEPROM_BYTES, BLOCK_BYTES)
        if any(flag & 3 >= Use.DATA for flag in flags[start : start + BLOCK_BYTES])
    )


def packet(block: int, data: bytes) -> bytes:
    """Return the packet of one block.

    Args:
        block: 0 to 127.
        data: its 16 bytes.

    Raises:
        ValueError: another block, or another number of bytes.

    >>> packet(127, bytes(11) + bytes.fromhex("00140e07c0")).hex()
    'ff000000000000000000000000140e07c018'
    """
    if not 0 <= block < EEPROM_BYTES // BLOCK_BYTES or len(data) != BLOCK_BYTES:
        raise ValueError(f"block {block} with {len(data)} bytes is not a block of the EEPROM")
    body = bytes((_FIRST + block,)) + data
    return body + bytes((-sum(body) & 0xFF,))


def blocks_of(packets: Iterable[bytes]) -> dict[int, bytes]:
    """Return the 16 bytes of each block, by block number: the inverse of `packets_of`.

    Raises:
        ImageError: a packet of another length, with a wrong checksum or first byte, or a
            block that comes twice.
    """
    blocks: dict[int, bytes] = {}
    for number, data in enumerate(packets):
        if len(data) != PACKET_BYTES:
            raise ImageError(f"packet {number} has {len(data)} bytes instead of {PACKET_BYTES}")
        if sum(data) & 0xFF:
            raise ImageError(f"packet {number} has a wrong checksum; send it again")
        block = data[0] - _FIRST
        if block < 0:
            raise ImageError(f"packet {number} starts with {data[0]:02X}h instead of 80h or more")
        if block in blocks:
            raise ImageError(f"packet {number} repeats block {block}")
        blocks[block] = data[1:-1]
    return blocks
