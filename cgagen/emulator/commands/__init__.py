"""The instructions that take time, as generator functions by their name in the opcode table.

See `cgagen.emulator.port` for the signature. Everything else is the chip's own.
"""

from collections.abc import Callable

from cgagen.emulator.commands.analog import dtmfout, freqout, pwm
from cgagen.emulator.commands.i2c import i2cin, i2cout
from cgagen.emulator.commands.lcd import lcdcmd, lcdin, lcdout
from cgagen.emulator.commands.onewire import owin, owout
from cgagen.emulator.commands.pulses import count, pulsin, pulsout, rctime
from cgagen.emulator.commands.serial_in import serin
from cgagen.emulator.commands.serial_out import serout, serout_flow
from cgagen.emulator.commands.shift import shiftin, shiftout
from cgagen.emulator.commands.xout import xout
from cgagen.emulator.port import Result
from cgagen.emulator.requests import Command

CommandFunction = Callable[..., Command[Result]]

COMMANDS: dict[str, CommandFunction] = {
    "COUNT": count,
    "DTMFOUT": dtmfout,
    "FREQOUT": freqout,
    "FREQOUT_TWO": freqout,
    "I2CIN": i2cin,
    "I2CIN_LOW": i2cin,
    "I2COUT": i2cout,
    "I2COUT_LOW": i2cout,
    "LCDCMD": lcdcmd,
    "LCDIN": lcdin,
    "LCDOUT": lcdout,
    "OWIN": owin,
    "OWOUT": owout,
    "PULSIN": pulsin,
    "PULSOUT": pulsout,
    "PWM": pwm,
    "RCTIME": rctime,
    "SERIN": serin,
    "SERIN_FLOW": serin,
    "SEROUT": serout,
    "SEROUT_FLOW": serout_flow,
    "SHIFTIN": shiftin,
    "SHIFTOUT": shiftout,
    "XOUT": xout,
}
