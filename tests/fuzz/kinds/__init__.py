"""One kind of input a file. Each has KIND, a `tests.fuzz.harness.Kind`; a file's being here registers it."""
