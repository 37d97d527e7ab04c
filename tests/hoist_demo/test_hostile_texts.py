"""The same hostile texts through every key of a file that takes a text, and into every kind of file we write."""

import csv
import json
import re
import subprocess
import tomllib
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import numpy as np
import pandas as pd
import pytest
from browser import BROWSER, look, run
from checkout import ROOT

from fmu_src.archive import read_archive
from fmu_src.documentation import index_html
from fmu_src.interface import Variable
from fmu_src.model_description import Build, model_description, model_description3
from fmu_src.profile import scalars
from fmu_src.shell.table import c_table
from fmu_src.ssp import System, export_ssp
from fmu_src.xml import xml_bytes
from hoist_demo.calibration.definition import MeasurementFile
from hoist_demo.calibration.page import write_rope_file
from hoist_demo.cases.hoist_file import HoistFile
from hoist_demo.drive_fmu.description import attachments
from hoist_demo.duty.schedule import read_schedule
from hoist_demo.files.reading import FileError, read
from hoist_demo.files.registry import rope_parameters
from hoist_demo.files.values import MAX_TEXT
from hoist_demo.report.html import page
from hoist_demo.report.html.study import study_report
from hoist_demo.report.markdown import render_markdown
from hoist_demo.report.rows import Report, SummaryRow
from hoist_demo.report.verdict import Verdict
from hoist_demo.report.verdict_row import VerdictRow
from hoist_demo.run.provenance import SourcedValue, write_data
from hoist_demo.study.definition import read_study
from hoist_demo.study.store import Results, Store
from hoist_demo.uncertainty.definition import UncertaintyFile
from rope_model import Datum
from rope_model.compiler import find_compiler
from rope_model.texts import (
    REPLACEMENT,
    c_string,
    csv_cell,
    html_text,
    printable,
    toml_string,
    xml_text,
)

CLOSES_THE_TABLE = (
    'x", NULL}}; __attribute__((constructor)) static void run(void) {system("id");} int y[] = {{"'
)
HOSTILE = [
    # C
    CLOSES_THE_TABLE,
    '"',
    "\\",
    '\\"',
    "\\\\",
    "x\\",
    '"; int main(void) { return 7; } //',
    "*/ int x; /*",
    "// x",
    '#include "/etc/passwd"',
    "??/",
    "??)",
    'a???/"b',
    "%s%n%d",
    "\\u0041",
    "\\x41",
    "\\1012",
    "\x01234",
    "\x00",
    "a\x00b",
    "line\nfeed",
    "carriage\rreturn",
    "tab\there",
    "\\\n",
    'L"x"',
    # XML and HTML
    "<script>alert(1)</script>",
    "</script><script>alert(1)</script>",
    "</title><img src=x onerror=alert(1)>",
    '" onload="alert(1)',
    "' onclick='alert(1)",
    "<!--",
    "-->",
    "]]>",
    "<![CDATA[x]]>",
    "&amp;",
    "&lt;b&gt;",
    "&#x3c;b>",
    "<!ENTITY x SYSTEM 'file:///etc/passwd'>",
    "\ufffe",
    "javascript:alert(1)",
    "$title ${body}",
    "{0} {x}",
    # TOML and files
    'x"\n[fixed]\nrope.EI = 1',
    "'''",
    "\x7f",
    "\x1b[31mred",
    "../../etc/passwd",
    "\u202ecod.exe",
    "\u2028",
    "日本\U0001f4a3",
]
PARAMETERS = rope_parameters()


def variable(text: str) -> Variable:
    """A parameter with the text wherever a variable has one that could come from a file."""
    return Variable(text, "parameter", "fixed", "Real", "", 0.0, text)


@pytest.mark.skipif(find_compiler() is None, reason="needs a C compiler")
def test_c_compiles_and_holds_the_exact_texts(tmp_path: Path) -> None:
    shell = ROOT / "fmu_src" / "shell"
    literals = ",\n".join(f"{{{c_string(text)}, sizeof {c_string(text)} - 1}}" for text in HOSTILE)
    (tmp_path / "variables.c").write_text(
        c_table([variable(text) for text in HOSTILE], 2), encoding="utf-8"
    )
    (tmp_path / "main.c").write_text(
        '#include <stdio.h>\n#include "model.h"\n'
        f"static const struct {{ const char *text; size_t size; }} TEXTS[] = {{\n{literals}\n}};\n"
        "int main(void) {\n    for (size_t k = 0; k < sizeof TEXTS / sizeof *TEXTS; k++) {\n"
        '        for (size_t i = 0; i < TEXTS[k].size; i++) printf("%02x", (unsigned char)TEXTS[k].text[i]);\n'
        '        printf(" ");\n'
        '        for (const char *c = MODEL_VARIABLES[k].name; *c; c++) printf("%02x", (unsigned char)*c);\n'
        '        printf(";");\n    }\n    return (int)MODEL_SCALARS - (int)(sizeof TEXTS / sizeof *TEXTS);\n}\n',
        encoding="utf-8",
    )
    compiler = [
        *(find_compiler() or ()),
        "-std=c99",
        "-trigraphs",
        "-Werror",
        f"-I{shell}",
        f"-I{shell / 'include'}",
    ]
    subprocess.run([*compiler, "main.c", "variables.c", "-o", "main"], cwd=tmp_path, check=True)
    said = subprocess.run([tmp_path / "main"], capture_output=True, text=True, check=True).stdout
    found = [row.split(" ") for row in said.removesuffix(";").split(";")]
    assert [bytes.fromhex(whole).decode() for whole, _ in found] == HOSTILE
    # a name ends where C ends it; files cannot have one with such a character
    assert [bytes.fromhex(name).decode() for _, name in found] == [
        text.partition("\0")[0] for text in HOSTILE
    ]


@pytest.mark.parametrize("fmi", [2, 3])
def test_model_descriptions_are_xml_with_the_texts(fmi: int) -> None:
    described = dict(enumerate(map(variable, HOSTILE)))
    for text in HOSTILE:
        build = Build("token", "1", "tool", "", name="HoistDrive", description=text)
        if fmi == 2:
            read = ElementTree.fromstring(xml_bytes(model_description(described, build)))
            names = [node.get("name") for node in read.iter("ScalarVariable")]
        else:
            root = model_description3(scalars(described), 999, build)
            read = ElementTree.fromstring(xml_bytes(root))
            _, *names = (node.get("name") for node in read.iter("Float64"))  # the first is time
        assert read.get("description") == xml_text(text)
        assert names == [xml_text(text) for text in HOSTILE]


def test_a_system_is_xml_with_the_texts(tmp_path: Path) -> None:
    for text in HOSTILE:
        path = export_ssp(tmp_path / "system.ssp", [], System(text, 1.0, 0.01, text))
        system = ElementTree.fromstring(read_archive(path)["SystemStructure.ssd"])
        assert {system.get("name"), system[0].get("name"), system[0].get("description")} == {
            xml_text(text)
        }


class Elements(HTMLParser):
    """Tags with their attributes, and what stands between them."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[tuple[str, tuple[str, ...]]] = []
        self.texts: list[str] = []
        self.attributes: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in ("code", "em"):  # the marks of our own texts
            self.tags.append((tag, tuple(name for name, _ in attrs)))
        self.attributes += [value or "" for _, value in attrs]

    def handle_data(self, data: str) -> None:
        self.texts.append(data)

    def handle_comment(self, data: str) -> None:
        self.tags.append(("comment", ()))


def _study_page(text: str, folder: Path) -> str:
    table = pd.DataFrame(
        {"variant": [text, "other"], text: [1.0, 2.0], "status": ["completed", text]}
    )
    table["cause"] = ["", text]
    meta = {"title": text, "parameters": ["variant"], "study file": text, text: text}
    return study_report(Results(table, {text: text}), meta, folder / "study.html").read_text(
        encoding="utf-8"
    )


def _sheet_page(text: str, folder: Path) -> str:
    parts = [(text, page.untitled_table((text,), [(text,)]) + page.paragraphs([text]))]
    parts.append(("", page.bars([page.Bar(text, 0.1, 0.9, 0.5)], [(0.5, text)], text)))
    parts.append(("", page.titled_table(text, [(text, text, text, text)])))
    return page.write_sheet(folder / "page.html", text, parts).read_text(encoding="utf-8")


PAGES: dict[str, Callable[[str, Path], str]] = {
    "rope FMU": lambda text, _: index_html([variable(text)], True),
    "drive FMU": lambda text, _: attachments(text, [variable(text)])[
        "documentation/index.html"
    ].decode(),
    "study": _study_page,
    "sheet": _sheet_page,
}


@pytest.mark.parametrize("kind", PAGES)
def test_pages_have_no_element_of_a_text(kind: str, tmp_path: Path) -> None:
    plain = Elements(PAGES[kind]("plain", tmp_path))
    for text in HOSTILE:
        found = Elements(PAGES[kind](text, tmp_path))
        assert found.tags == plain.tags, text
        # HTML, too, has one line feed for a carriage return
        shown = re.sub("\r\n?", "\n", xml_text(text)).strip()
        assert shown in re.sub("\r\n?", "\n", "".join(found.texts)), text


def test_a_run_and_its_data_have_no_element_of_a_text() -> None:
    for text in HOSTILE:
        data = page.running((), {text: [text]})
        inside = data[data.index(">") + 1 : data.index("</script>")]
        assert json.loads(inside) == {text: [text]}
        assert [tag for tag, _ in Elements(data).tags] == ["script", "script"]
        assert Elements(f'<p title="{html_text(text)}">').tags == [("p", ("title",))]


@pytest.mark.slow
@pytest.mark.skipif(BROWSER is None, reason="no Chromium found: apt-get install chromium")
def test_a_browser_makes_no_element_of_a_text(tmp_path: Path) -> None:
    table = pd.DataFrame(
        {"variant": HOSTILE, "speed": [*map(float, range(50))], "status": "completed", "cause": ""}
    )
    table.loc[1::2, "cause"] = table["variant"]
    meta = {"title": CLOSES_THE_TABLE, "parameters": ["variant"]}
    study = study_report(Results(table, dict.fromkeys(HOSTILE, "m")), meta, tmp_path / "study.html")
    speeds = table["speed"].to_numpy()[np.arange(301) % 50]
    winding = run(tmp_path, **dict.fromkeys(HOSTILE, speeds))
    for path in (study, winding):
        seen = look(
            path,
            "seen.strange = document.querySelectorAll('img, iframe, b, [onerror], [onload]').length",
            900,
        )
        assert seen.said["strange"] == 0
        assert not seen.console


def test_markdown_has_no_element_of_a_text() -> None:
    for text in HOSTILE:
        tables = (text, [(text, text, text, text)])
        verdict = Verdict(text, (VerdictRow(text, text, text, where=text),), (text,))
        report = Report(text, verdict, tables, [SummaryRow(text, text, text)], [tables])
        assert "<" not in render_markdown(report, []), text


def test_a_rope_file_reads_back(tmp_path: Path) -> None:
    for text in HOSTILE:
        datum = Datum(1.0, 2.0, "1", text, text)  # type: ignore[arg-type]
        known = SimpleNamespace(
            construction=text, diameter=0.05, length=60.0, lay=text, data={"torque_factor": datum}
        )
        problem = SimpleNamespace(
            rope=lambda norm_params: SimpleNamespace(**dict.fromkeys(FOLLOWING, 1.0)), sought={}
        )
        fit = SimpleNamespace(norm_params=None, contradicted=False, held=np.zeros(0, dtype=int))
        measured = SimpleNamespace(problem=problem, path=SimpleNamespace(name=text))
        found = SimpleNamespace(
            calibrated_rope=known, data={}, fit=fit, measurement_file=measured, names=()
        )
        path = write_rope_file(found, tmp_path / "rope.toml")  # type: ignore[arg-type]
        read = tomllib.loads(path.read_text(encoding="utf-8"))
        assert read["rope"]["construction"] == read["rope"]["lay"] == text
        assert read["known"]["torque_factor"] == {
            "low": 1.0,
            "high": 2.0,
            "status": text,
            "source": text,
        }
        assert [*read] == ["rope", "known", "fixed"]


FOLLOWING = ("mass_per_length", "Qa", "Qb", "Qc", "Qd", "EI", "rhoJ", "length", "diameter")
MEASURED = '[rope]\nconstruction = "34x7"\ndiameter = 0.046\nlength = 60.0\n'
WIDTH = '[[measured]]\nwhat = "loop width"\nvalue = 3.05\nsigma = 0.05\n'
READERS: dict[str, tuple[Callable[[Path], object], str]] = {
    "hoist name": (lambda path: read(path, HoistFile).case.name, "name = {}\n[[rope]]\n"),
    "hoist source": (
        lambda path: read(path, HoistFile).case.source,
        'name = "a"\nsource = {}\n[[rope]]\n',
    ),
    "duty title": (
        lambda path: read_schedule(path).header.title,
        "[duty]\ntitle = {}\n[[trip]]\nwinding.travel = 10.0\n",
    ),
    "uncertain title": (
        lambda path: read(path, UncertaintyFile).header.title,
        "[uncertain]\ntitle = {}\n" + MEASURED,
    ),
    "measured name": (
        lambda path: read(path, MeasurementFile).measurements[0].name,
        MEASURED + WIDTH + "name = {}\n",
    ),
    "known source": (
        lambda path: (
            read(path, MeasurementFile).problem.catalogue_rope.data["torque_factor"].source
        ),
        MEASURED + "[known]\ntorque_factor = {{ low = 0.1, high = 0.1, source = {} }}\n" + WIDTH,
    ),
}


@pytest.mark.parametrize("kind", READERS)
def test_texts_of_files_are_kept_or_refused_with_a_cure(kind: str, tmp_path: Path) -> None:
    read, template = READERS[kind]
    path = tmp_path / "file.toml"
    for text in [*HOSTILE, "x" * (MAX_TEXT + 1)]:
        path.write_text(template.format(toml_string(text)), encoding="utf-8")
        if printable(text) == text and len(text) <= MAX_TEXT:
            assert read(path) == text
            continue
        told = refusal(read, path)
        assert re.search(
            r"must (be a line of printable characters: leave|have at most 200: shorten)", told
        ), text


#: what reads the files of each folder of the documents, which have all keys but these
FILES: dict[str, Callable[[Path], object]] = {
    "duties": lambda path: read_schedule(path),
    "hoists": lambda path: read(path, HoistFile).case,
    "measurements": lambda path: read(path, MeasurementFile),
    "studies": lambda path: read_study(path, path.with_name("none.fmu")),
    "uncertain": lambda path: read(path, UncertaintyFile),
}
MORE = {
    "hoists": "name = 'a'\n[[rope]]\nEI = { value = 300.0, unit = 'N.m2', status = 'assumed', source = 'b' }\n",
    "duties": "[duty]\n[fixed]\nfrom = 'rope.toml'\n[[trip]]\nwinding.travel = 10.0\n",
    "studies": "[study]\nsubject_to = { swing_right = 1.0 }\nover = ['rope.EI']\n[sample]\nmethod = 'grid'\nruns = 3\n",
    "measurements": MEASURED
    + "[known]\ntorque_factor = { low = 0.1, high = 0.1, status = 'assumed', source = 'a' }\n"
    + "[sought]\nEI = { low = 1, high = 2 }\n"
    + WIDTH,
}
#: a key, a value or the name of a table
WORD = re.compile(r"#.*|\"[^\"\n]*\"|'[^'\n]*'|[\w.+-]+")


def examples() -> Iterator[tuple[str, str]]:
    """Yield the kind and the text of each file."""
    for kind in FILES:
        for path in sorted((ROOT / "examples" / kind).glob("*.toml")):
            yield kind, path.read_text("utf-8")
    yield from MORE.items()


@pytest.mark.parametrize(("kind", "example"), [*examples()])
def test_every_key_value_and_table_takes_the_texts_or_refuses_them_in_words(
    kind, example, tmp_path
):
    path = tmp_path / "file.toml"
    words = {found[0]: found for found in WORD.finditer(example) if not found[0].startswith("#")}
    for k, word in enumerate(words.values()):
        for text in HOSTILE[k % 50 :: 50]:
            path.write_text(
                example[: word.start()] + toml_string(text) + example[word.end() :],
                encoding="utf-8",
            )
            assert refusal(FILES[kind], path) or printable(text) == text, (word[0], text)


def refusal(read: Callable[[Path], object], path: Path) -> str:
    try:
        read(path)
    except FileError as error:
        said = str(error).replace("\n", "")
        if printable(said) == said:
            return said
    return ""


def test_halves_of_characters_become_replacements() -> None:
    half = "rope\udcff.toml"  # as Python has a file's name that is not UTF-8
    assert tomllib.loads(f"x = {toml_string(half)}") == {"x": f"rope{REPLACEMENT}.toml"}
    assert html_text(half) == printable(half) == f"rope{REPLACEMENT}.toml"


#: what a spreadsheet would compute, and what it would not
FORMULAS = [
    "=1+1",
    "+x",
    "@SUM(A1)",
    "-cmd|' /C calc'!A0",
    " =a",
    "\t=x",
    "\r=x",
    "-",
    '=HYPERLINK("http://x")',
]
PLAIN = ["-5", "+3.5", "-5e3", "-inf", "a=b", "x", ""]


def test_a_spreadsheet_computes_no_text(tmp_path: Path) -> None:
    written = [f"'{text}".replace("\r", " ") for text in FORMULAS]
    assert [csv_cell(text) for text in FORMULAS] == written
    assert [csv_cell(value) for value in [*PLAIN, -5.0, 3, None, True]] == [
        *PLAIN,
        -5.0,
        3,
        None,
        True,
    ]
    store = Store(tmp_path / "study")
    store.write_table([{"variant": text, "=x": -1.5, "runs": 2} for text in FORMULAS], {}, "")
    data = write_data(
        [SourcedValue("rope.EI", text, "N m^2", "given") for text in FORMULAS],
        tmp_path / "data.csv",
    )
    for path, column in ((tmp_path / "study" / "results.csv", 0), (data, 1)):
        with path.open(newline="", encoding="utf-8") as file:
            header, *rows = csv.reader(file)
        assert not any(cell.startswith("=") for cell in header)
        assert [row[column] for row in rows] == written
    with (tmp_path / "study" / "results.csv").open(newline="", encoding="utf-8") as file:
        assert [row[1:] for row in csv.reader(file)][1:] == [["-1.5", "2"]] * len(FORMULAS)
    # programs read the other table, which has the texts as they are
    assert [*pd.read_parquet(tmp_path / "study" / "results.parquet")["variant"]] == FORMULAS
