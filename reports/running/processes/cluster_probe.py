"""What a worker of a cluster is asked first. It travels as its own code, for the worker may not have the suite."""


def identify(solvers: tuple[str, ...], files: tuple[str, ...]):
    """The identity of the machine this runs on, or in a phrase why it has none."""
    try:
        from reports.running.processes import cluster_worker

        return cluster_worker.ask_identity(solvers, files)
    except Exception as problem:
        return f"it has not the suite, or not all of it ({type(problem).__name__}: {problem})"
