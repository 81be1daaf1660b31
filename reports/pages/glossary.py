"""The glossary: what the words of pages, tables and help texts mean."""

from itertools import groupby

from plumbline.reports.html.template import filled_page
from plumbline.reports.words.glossary import glossary

PAGE = filled_page(
    "glossary",
    "Glossary",
    96,
    lambda _: {"sections": [(title, list(group)) for title, group in groupby(glossary(), key=lambda entry: entry.section)]},
    concerns=lambda _: bool(glossary()),
)
