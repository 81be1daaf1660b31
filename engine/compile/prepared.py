"""What the compiler does before its first function, done by the import: for a process that others are forked from."""

from engine.compile.jit import prepare

prepare()
