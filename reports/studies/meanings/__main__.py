"""`python -m reports.studies.meanings > docs/engine_parameters.md`"""

from ...running.calls import Calls
from .. import Request
from .study import as_text, run

if __name__ == "__main__":
    with Calls() as calls:
        print(as_text(run(Request(), calls)))
