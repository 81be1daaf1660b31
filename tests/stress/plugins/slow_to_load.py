"""A package that takes two seconds of CPU time to load."""

from faulty import busy_for

busy_for(2.1)
