r"""The behaviour of the chips, and of what is wired to them, on one integer clock.

A chip executes the decoded tokens of a real EEPROM image (`cgagen.stamp.decode`). It knows no part
and no world: it reads and drives pins. Wires join pins and parts; parts are circuits. Time is in
whole nanoseconds and nothing here asks the computer's clock, so runs repeat exactly.

A program of any kind, run and looked at by the names that it gives things. A class that learns
what a pin does might try this one:

>>> from cgagen.emulator.programs import bench_of_sources
>>> from cgagen.tokenizer import compile_source
>>> compiled = compile_source('''
... ' {$STAMP BS2}
... ' {$PBASIC 2.5}
... Led     PIN 3
... left    VAR Byte
... seen    VAR Byte(4)
... Limits  DATA 3, 250
...   READ Limits, left
... Blink:
...   HIGH Led
...   PAUSE 10
...   LOW Led
...   left = left - 1
...   seen(left) = left * 7
...   IF left > 0 THEN Blink
...   END
... ''', "blink.bs2")
>>> bench = bench_of_sources({0: compiled})
>>> chip = bench.chip("main")

Run until something is so; look at variables, pins and EEPROM by name:

>>> chip.run_until(lambda: chip.level("Led") == 1, limit_ns=1_000_000_000)
True
>>> chip.ram["left"], chip.ram["left.BIT0"], [*chip.data("Limits")]
(3, 1, [3, 250])

A snapshot is exact, in the middle of anything; what follows can be had again:

>>> before = bench.snapshot()
>>> bench.run(until_ns=50_000_000)
>>> chip.ended, chip.ram["left"], chip.ram.array("seen")
(<End.END: 'END'>, 0, (0, 7, 14, 0))
>>> bench.restore(before)
>>> chip.ended, bench.variable("main.left")
(None, 3)

Hooks on lines, labels, addresses and pins see each moment; each returns how to end it:

>>> lefts, levels = [], []
>>> end_it = chip.on_line(13, lambda chip: lefts.append(chip.ram["left"]))
>>> end_this = chip.on_pin("Led", levels.append)
>>> bench.run(until_ns=50_000_000)
>>> lefts, levels
([3, 2, 1], [0, 1, 0, 1, 0])

All variables at once; what is not there is said in a sentence:

>>> dict(chip.ram)
{'left': 0, 'seen': 0}
>>> chip.ram["lift"]
Traceback (most recent call last):
cgagen.errors.SymbolError: blink.bs2: no variable lift; did you mean left?

More of it: `help` says what a chip can do (`cgagen.emulator.chip.Chip`), what a bench with several
chips and parts can (`cgagen.emulator.bench.Bench`), and how a file describes one
(`cgagen.emulator.bench_file`).
"""
