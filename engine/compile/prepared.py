"""What the compiler does before its first function, done by the import: for a process that others are forked from."""

from engine.compile.compilers import prepare

prepare()
