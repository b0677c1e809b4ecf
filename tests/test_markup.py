"""Pieces of HTML: what is put in comes out, nothing breaks out of its place."""

from __future__ import annotations

import base64
import re
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from matplotlib.figure import Figure

from pmesh.cases.markup import anchor, drawn, image, number, spark, table, video


def test_a_table_has_its_names_in_the_head_and_in_every_cell() -> None:
    text = table(("what", "value"), [("drag", "1.3"), ("lift", "0.4")], numbers=[1])
    rows = ET.fromstring(text).findall(".//tr")
    assert [cell.text for cell in rows[0]] == ["what", "value"]
    assert [[cell.text for cell in row] for row in rows[1:]] == [["drag", "1.3"], ["lift", "0.4"]]
    assert [row[1].get("data-name") for row in rows[1:]] == ["value", "value"]
    assert rows[1][1].get("class") == "number"
    with pytest.raises(ValueError, match="zip"):
        table(("what", "value"), [("drag",)], numbers=[])


def test_pictures_are_inside_the_page_and_described() -> None:
    text = image(b"picture", "png", 'a "quote" & <tag>')
    assert base64.b64decode(re.search('base64,([^"]*)', text).group(1)) == b"picture"
    assert 'alt="a &quot;quote&quot; &amp; &lt;tag&gt;"' in text
    assert "<tag>" not in text
    assert base64.b64encode(b"film").decode() in video(b"film", "a & b")
    seen = base64.b64decode(re.search('base64,([^"]*)', drawn(Figure((1, 1)), "x")).group(1))
    assert seen.startswith(b"\x89PNG")


def test_a_small_line_goes_up_where_the_column_does() -> None:
    time = np.linspace(0, 1, 500)
    points = re.search('points="([^"]*)"', spark(time, time)).group(1).split()
    heights = [float(point.split(",")[1]) for point in points]
    assert len(heights) == 121
    assert heights[0] > heights[60] > heights[-1]  # y points down
    assert "15.0" in spark(time, np.ones(500))
    assert spark(time, np.full(500, np.nan)) == ""


def test_numbers_and_addresses_are_short() -> None:
    assert (number(1.234567), number(None), number(1e-9)) == ("1.2346", "", "1e-09")
    assert anchor("Cost and version") == "cost-and-version"
