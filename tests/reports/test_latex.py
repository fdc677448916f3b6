"""Tables of a paper: six columns, caption, label, numbers that siunitx reads, nothing that LaTeX interprets."""

import re
import shutil
import subprocess

import pandas as pd
import pytest

from reports.page import latex
from reports.page.text import shorten

FRAME = pd.DataFrame(
    {
        "case": ["disc_in_circle[mu=0.2]", "50 % & more"],
        "constant": [1, 1],
        "long": ["x" * 80, "y" * 80],
        "solver": ["a_b", "c"],
        "time": [0.630053764, 2.0],
        "error": [1.5e-7, float("nan")],
        "steps": [1700.0, 12.0],
        "one": [1, 2], "two": [3, 4], "three": [5, 6],
    }
)  # fmt: skip


def test_a_table_has_six_short_columns_that_vary():
    assert latex.chosen_columns("any", FRAME) == ["case", "solver", "time", "error", "steps", "one"]
    assert latex.chosen_columns("truth", FRAME) == ["case", "time"]  # as listed for that table


def test_it_has_caption_label_numbers_and_the_command():
    text = latex.table("any", FRAME, "Errors of 50 % or more", "python -m reports.build --paper", shorten)
    assert r"\caption{Errors of 50 \% or more.}\label{tab:any}" in text
    assert "% Make it again: python -m reports.build --paper" in text
    rows = [line for line in text.splitlines() if "disc" in line or "more &" in line]
    assert rows == [
        r"disc\_in\_circle[mu=0.2] & a\_b & \num{0.630053764} & \num{1.5e-07} & \num{1700} & \num{1} \\",
        r"50 \% \& more & c & \num{2} &  & \num{12} & \num{2} \\",
    ]
    assert r"\begin{longtable}{llrrrr}" in text and "time / s" in text


@pytest.mark.parametrize("text", ["1,700", "0.5", "-1.2e-07", "12"])
def test_a_number_of_a_table_is_one_of_siunitx(text):
    inside = re.fullmatch(r"\\num\{(.*)\}", latex.cell(text))[1]
    assert float(inside) == float(text.replace(",", ""))


@pytest.mark.parametrize(
    ("text", "expected"), [("h=1e-3", "h=1e-3"), ("μ_0", r"\ensuremath{\mu}\_0"), ("a\\b", r"a\textbackslash{}b")]
)
def test_text_is_escaped(text, expected):
    assert latex.cell(text) == expected


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed")
def test_pdflatex_sets_it(tmp_path):
    text = latex.table("any", FRAME, "Errors", "a_command --with=100%", shorten)
    head = "\\documentclass{article}\\usepackage{longtable,booktabs,siunitx}\\begin{document}"
    (tmp_path / "t.tex").write_text(f"{head}\n{text}\n\\end{{document}}")
    done = subprocess.run(["pdflatex", "-halt-on-error", "t.tex"], cwd=tmp_path, capture_output=True, timeout=120)
    assert done.returncode == 0, done.stdout[-2000:]
