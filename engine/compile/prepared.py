"""What the compiler does before its first function, done by the import: for a process that others are forked from."""

from plumbline.engine.compile.jit import prepare

prepare()
