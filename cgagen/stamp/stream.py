"""The program as a stream of bits: it starts at the last byte of the EEPROM and runs down.

Stream bit n is bit 7 - n % 8 of byte 2047 - n // 8. Ref: S3.
"""


def stream_of(eeprom: bytes) -> str:
    """Return the stream of a slot's bytes as characters 0 and 1, bit 0 first.

    >>> stream_of(bytes(2047) + bytes([0xC0]))[:4]
    '1100'
    """
    return f"{int.from_bytes(eeprom, 'little'):0{8 * len(eeprom)}b}"


def address_at(stream: str, bit: int) -> int:
    """Return the address, a stream bit, that the 14 bits from `bit` on hold.

    They are 3 bits of address % 8, then 11 bits of address // 8.

    >>> address_at("110" + "00000000001", 0)
    14
    """
    return int(stream[bit : bit + 3], 2) + 8 * int(stream[bit + 3 : bit + 14], 2)
