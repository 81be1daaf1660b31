"""A package that takes two and a half seconds of CPU time to load."""

from faulty import busy_for

busy_for(2.5)
