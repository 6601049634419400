"""Serial frames as the documents draw them: modes, bit times and bits."""

SEVEN, INVERTED, OPEN = 0x2000, 0x4000, 0x8000


MODES = [0, SEVEN, INVERTED, INVERTED | SEVEN]
NO_LABEL = 1
"""What a SERIN without a label pushes for its time-out."""


RATES = {  # S2 p. 394, 395, 419: baud rates and the words of the manual's tables
    "BS2": [(300, 3313), (600, 1646), (1200, 813), (2400, 396), (4800, 188), (9600, 84),
            (19200, 32), (38400, 6), (50000, 0)],
    "BS2p": [(1200, 2063), (2400, 1021), (4800, 500), (9600, 240), (19200, 110), (38400, 45),
             (115200, 1)],
}  # fmt: skip


def frame_8n1(byte: int) -> int:
    return 1 << 9 | byte << 1


def frame_7e1(byte: int) -> int:
    byte &= 0x7F
    return 1 << 9 | (bin(byte).count("1") % 2) << 8 | byte << 1
