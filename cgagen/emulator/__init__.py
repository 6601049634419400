"""The behaviour of the chips, and of what is wired to them, on one integer clock.

A chip executes the decoded tokens of a real EEPROM image (`cgagen.stamp.decode`). It knows no part
and no world: it reads and drives pins. Wires join pins and parts; parts are circuits. Time is in
whole nanoseconds and nothing here asks the computer's clock, so runs repeat exactly.
"""
