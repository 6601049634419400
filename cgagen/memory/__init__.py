"""What a program takes of its chip: EEPROM by routine and label, RAM by size, depth of calls."""

from dataclasses import asdict, dataclass
from typing import Any

from cgagen.errors import BudgetError
from cgagen.memory.routines import nesting, routines_of
from cgagen.stamp.chips import EEPROM_BYTES
from cgagen.stamp.compiled import Compiled, VariableCounts
from cgagen.stamp.data import DataBlock, data_of

__all__ = ["DEEPEST_GOSUB", "MOST_GOSUBS", "DataBlock", "MemoryReport", "ProgramPart", "report"]

DEEPEST_GOSUB = 4
"""Calls that may be open at a time; a fifth loses the first's way back. Ref: S2 p. 210."""

MOST_GOSUBS = 255
"""GOSUBs of one program. Ref: S3 (error 145)."""


@dataclass(frozen=True, slots=True)
class ProgramPart:
    """The bits from one label to the next.

    Attributes:
        name: the label.
        line: its line, from 1.
        bits: what it takes of the program; the last one's with the final END and padding.
    """

    name: str
    line: int
    bits: int


@dataclass(frozen=True, slots=True)
class MemoryReport:
    """What one compiled program takes.

    Attributes:
        name: the source.
        model: the chip's name.
        header_bits: start address and return slots.
        parts: the routines, in source order.
        data: the DATA blocks, in source order; None where they cannot be told apart.
        program_bytes: the program, header included.
        data_bytes: all DATA, reserved bytes included.
        variables: declared variables by size. Fixed names (W1, B3) are not seen.
        ram_bytes: RAM of the chip for variables.
        gosubs: GOSUBs in the source.
        call_chain: the deepest chain of calls; None where a routine calls itself.
    """

    name: str
    model: str
    header_bits: int
    parts: tuple[ProgramPart, ...]
    data: tuple[DataBlock, ...] | None
    program_bytes: int
    data_bytes: int
    variables: VariableCounts
    ram_bytes: int
    gosubs: int
    call_chain: tuple[str, ...] | None

    @property
    def free_bytes(self) -> int:
        """EEPROM bytes that neither program nor DATA takes."""
        return EEPROM_BYTES - self.program_bytes - self.data_bytes

    @property
    def free_percent(self) -> float:
        """The same, of all 2,048."""
        return 100 * self.free_bytes / EEPROM_BYTES

    @property
    def ram_used_bytes(self) -> int:
        """RAM bytes that hold a declared variable, a part of a byte counting whole."""
        return -(-self.variables.total_bits // 8)

    @property
    def ram_free_bytes(self) -> int:
        """RAM bytes that no declared variable touches."""
        return self.ram_bytes - self.ram_used_bytes

    @property
    def gosub_depth(self) -> int | None:
        """Calls open at a time, at most; None: without bound."""
        return None if self.call_chain is None else len(self.call_chain) - 1

    def check(
        self,
        min_free_percent: float = 0.0,
        min_free_ram_bytes: int = 0,
        max_gosub_depth: int = DEEPEST_GOSUB,
    ) -> None:
        """Refuse a program that leaves too little.

        Raises:
            BudgetError: what is short, by how much, and where it goes.
        """
        if self.free_percent < min_free_percent:
            largest = max(self.parts, key=lambda part: part.bits)
            raise BudgetError(
                f"{self.name}: leaves {self.free_bytes} of {EEPROM_BYTES} EEPROM bytes free "
                f"({self.free_percent:.1f} %), {min_free_percent:g} % are asked for; shorten it, "
                f"most is in {largest.name} (line {largest.line}, {largest.bits / 8:.0f} bytes)"
            )
        if self.ram_free_bytes < min_free_ram_bytes:
            raise BudgetError(
                f"{self.name}: leaves {self.ram_free_bytes} of {self.ram_bytes} RAM bytes free, "
                f"{min_free_ram_bytes} are asked for; use smaller variables, or some of them twice"
            )
        depth = self.gosub_depth
        if depth is None:
            raise BudgetError(
                f"{self.name}: a routine calls itself, or jumps back to its caller, before its "
                f"RETURN, so that the way back is lost after {DEEPEST_GOSUB} calls; let it RETURN"
            )
        if depth > max_gosub_depth:
            raise BudgetError(
                f"{self.name}: calls are {depth} deep ({' > '.join(self.call_chain or ())}), "
                f"{max_gosub_depth} are allowed; write the innermost where it is called"
            )

    def to_text(self) -> str:
        """Return the report for a reader; the same program gives the same bytes."""
        return "\n".join([*self._eeprom(), "", *self._ram(), "", *self._calls()]) + "\n"

    def to_json(self) -> dict[str, Any]:
        """Return the report for a program."""
        return asdict(self) | {
            "variables": self.variables._asdict(),
            "free_bytes": self.free_bytes,
            "free_percent": round(self.free_percent, 2),
            "ram_used_bytes": self.ram_used_bytes,
            "ram_free_bytes": self.ram_free_bytes,
            "gosub_depth": self.gosub_depth,
        }

    def _eeprom(self) -> list[str]:
        lines = [f"{self.name} ({self.model}): {EEPROM_BYTES} bytes of EEPROM", ""]
        for what, count in (
            ("program", self.program_bytes),
            ("DATA", self.data_bytes),
            ("free", self.free_bytes),
        ):
            lines.append(f"  {what:<24}{count:>6} bytes{100 * count / EEPROM_BYTES:>7.1f} %")
        lines += ["", f"  {'program by routine':<24}{'line':>6}{'bits':>8}{'bytes':>8}"]
        header = f"(header, {self.gosubs} GOSUBs)"
        lines.append(f"  {header:<24}{'':>6}{self.header_bits:>8}{self.header_bits / 8:>8.1f}")
        for part in self.parts:
            lines.append(f"  {part.name:<24}{part.line:>6}{part.bits:>8}{part.bits / 8:>8.1f}")
        if self.data:
            lines += ["", f"  {'DATA by label':<24}{'line':>6}{'address':>8}{'bytes':>8}"]
            for block in self.data:
                lines.append(f"  {block.name:<24}{block.line:>6}{block.address:>8}{block.bytes:>8}")
        return lines

    def _ram(self) -> list[str]:
        counts = ", ".join(
            f"{count} {size if count != 1 else size.removesuffix('s')}"
            for size, count in reversed(self.variables._asdict().items())
        )
        return [
            f"{self.ram_bytes} bytes of RAM",
            "",
            f"  {'used':<24}{self.ram_used_bytes:>6} bytes: {counts}",
            f"  {'free':<24}{self.ram_free_bytes:>6} bytes",
        ]

    def _calls(self) -> list[str]:
        if self.call_chain is None:
            return ["GOSUB depth: without bound, a routine calls itself"]
        chain = f": {' > '.join(self.call_chain)}" if self.gosub_depth else ""
        return [f"GOSUB depth: {self.gosub_depth} of {DEEPEST_GOSUB}{chain}"]


def report(compiled: Compiled) -> MemoryReport:
    """Return what a compiled program takes of its chip.

    Depth of calls and DATA by label are read from the source (`cgagen.memory.routines`,
    `cgagen.stamp.data`), everything else is the tokenizer's.
    """
    routines = routines_of(compiled)
    return MemoryReport(
        name=compiled.name,
        model=compiled.image.model.name,
        header_bits=compiled.start_bit,
        parts=tuple(ProgramPart(r.name, r.line, r.bits) for r in routines),
        data=data_of(compiled),
        program_bytes=compiled.program_bytes,
        data_bytes=compiled.data_bytes,
        variables=compiled.variables,
        ram_bytes=compiled.image.model.variable_bytes,
        gosubs=compiled.gosub_slots,
        call_chain=nesting(routines),
    )
