"""What a terminal is shown: one line that moves, in a log next to nothing, and at the end the answer and the path."""

import io

from rich.console import Console

from reports.running import progress
from reports.running.progress import Display, usual


def test_the_time_left_is_that_of_the_whole_at_the_pace_seen(monkeypatch):
    """Steps of 100, 200 and 100 s as a rule, on a machine half as fast."""
    now = [0.0]
    monkeypatch.setattr(progress.time, "monotonic", lambda: now[0])
    display, output = Display({"a": 100.0, "b": 200.0, "c": 100.0}), []
    monkeypatch.setattr(display, "_show", lambda step, done, total, left: output.append((step, done, left)))

    def slowly(count, seconds):
        for i in range(count):
            now[0] += seconds
            yield i

    with display:
        assert list(display("a", 4, slowly(4, 50.0))) == [0, 1, 2, 3]
        assert list(display("b (3 more from the store)", 4, slowly(4, 100.0))) == [0, 1, 2, 3]
        list(display("c", 2, slowly(2, 100.0)))
    left = {(step, done): seconds for step, done, seconds in output}
    assert abs(left["b (3 more from the store)", 2] - (200.0 + 200.0)) < 20.0
    assert abs(left["c", 1] - 100.0) < 10.0 and left["c", 2] == 0.0


def test_a_log_is_left_quiet_and_hears_of_a_long_step(monkeypatch, capsys):
    with Display(usual(3, True, True), Console(file=io.StringIO())) as display:
        assert list(display("runs", 500, iter(range(500)))) == list(range(500))
        assert capsys.readouterr().err == ""
        monkeypatch.setattr(progress, "LOG_SECONDS", -1.0)
        list(display("figures", 2, iter("ab")))
    assert "figures: 1 of 2" in capsys.readouterr().err


def test_a_terminal_sees_step_count_and_time_left():
    shown = io.StringIO()
    with Display(usual(3, True, True), Console(file=shown, force_terminal=True, width=100)) as display:
        list(display("runs", 2, iter("ab")))
        display._bars.refresh()
    assert "runs 2/2" in shown.getvalue() and "left" in shown.getvalue()
